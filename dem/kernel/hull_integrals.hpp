// SPDX-License-Identifier: LGPL-3.0-or-later
// Integrals over the boundary of K, eight triangles at a time. Sums are kept in eight parts for every width, so that
// all give the same bits.
#pragma once

#include "dem/kernel/hull_topology.hpp"

namespace grus::dem {
namespace {

constexpr int parts = 8 / width;

/// Eight triangles.
struct Triangles {
  double p[3][8], q[3][8], apex[3][8], n[3][8], twice[8];
};

GRUS_INLINE void load3(const double (*from)[8], int at, Real3& to) {
  load(from[0] + at, to.x), load(from[1] + at, to.y), load(from[2] + at, to.z);
}
GRUS_INLINE void store3(const Real3& v, double (*to)[8], int at) {
  store(v.x, to[0] + at), store(v.y, to[1] + at), store(v.z, to[2] + at);
}
/// Lanes [at, at + width).
struct Lane3 {
  Real3 p, q, apex, n;
  Real twice;
  GRUS_INLINE Lane3(const Triangles& t, int at) {
    load3(t.p, at, p), load3(t.q, at, q), load3(t.apex, at, apex), load3(t.n, at, n), load(t.twice + at, twice);
  }
};

struct Sum {
  Real r[parts];
  GRUS_INLINE Sum() {
    for (int k = 0; k < parts; ++k) r[k] = Real(0.0);
  }
};

/// Of a vector and a number.
struct Sums {
  Sum x, y, z, w;
  GRUS_INLINE void add(int k, Real by, const Real3& v) {
    x.r[k] = fused(by, v.x, x.r[k]), y.r[k] = fused(by, v.y, y.r[k]), z.r[k] = fused(by, v.z, z.r[k]);
  }
  GRUS_INLINE void total(double* to) const { add_eight(x.r, y.r, z.r, w.r, to); }
};

/// Six times the volume and 24 times its first moment; of A's surface twice the area vector and twice the area.
struct Solid {
  Sums body, surface;
};

/// Triangles about the point o of K. Those that are A's are kept, with those of B beside them, which count nothing
/// there.
template <class Known>
GRUS_INLINE void add_triangles(const double* points, const double* planes, const Known& b, const double* o,
                               Triangles* t, Solid& solid) {
  const Real3 origin{Real(o[0]), Real(o[1]), Real(o[2])};
  for (int at = 0; at < b.borders; at += 8)
    for (int u = 0; u < parts; ++u) {
      const int k = at + u * width;
      Real3 p, q, apex, n;
      Real offset, unused;
      load4(points, b.border[0] + k, 4, p.x, p.y, p.z, unused),
          load4(points, b.border[1] + k, 4, q.x, q.y, q.z, unused);
      load4(points, b.border[2] + k, 4, apex.x, apex.y, apex.z, unused);
      load4(planes, b.border[3] + k, 4, n.x, n.y, n.z, offset);
      const Real height = offset - dot(n, origin), twice = dot(n, cross(p - apex, q - apex)), moved = height * twice;
      p = p - origin, q = q - origin, apex = apex - origin;
      solid.body.w.r[u] = solid.body.w.r[u] + moved;
      solid.body.add(u, moved, p + q + apex);
      if (at >= b.borders_a) continue;
      const int own = b.borders_a - k < 0 ? 0 : b.borders_a - k > width ? width : b.borders_a - k;
      const Real counted = kept_lanes(mask_of((1u << own) - 1), twice);
      solid.surface.w.r[u] = solid.surface.w.r[u] + counted;
      solid.surface.add(u, counted, n);
      Triangles& to = t[at / 8];
      const int lane = u * width;
      store3(p, to.p, lane), store3(q, to.q, lane), store3(apex, to.apex, lane);
      store3(n, to.n, lane), store(counted, to.twice + lane);
    }
}

/// The plane that `x` is least deep below: its normal and offset.
GRUS_INLINE void find_shallowest(const double* s, int space, const double* x, double* plane) {
  double depth[most_faces], each[width];
  Real least(1e300);
  for (int f = 0; f < space; f += width) {
    Real nx, ny, nz, d;
    load(s + f, nx), load(s + space + f, ny), load(s + 2 * space + f, nz), load(s + 3 * space + f, d);
    const Real below = less_fused(less_fused(less_fused(d, nx, x[0]), ny, x[1]), nz, x[2]);
    store(below, depth + f);
    least = smaller(least, below);
  }
  store(least, each);
  double most = each[0];
  for (int k = 1; k < width; ++k) most = each[k] < most ? each[k] : most;
  int best = 0;
  for (int f = space - width; f >= 0; f -= width) {
    Real d;
    load(depth + f, d);
    const unsigned above = bits(less(Real(most), d)), is = ~above & ((1u << width) - 1);
    best = is != 0 ? f + __builtin_ctz(is) : best;
  }
  for (int k = 0; k < 4; ++k) plane[k] = s[k * space + best];
}

GRUS_INLINE double dot3(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
GRUS_INLINE void cross3(const double* a, const double* b, double* to) {
  to[0] = a[1] * b[2] - a[2] * b[1], to[1] = a[2] * b[0] - a[0] * b[2], to[2] = a[0] * b[1] - a[1] * b[0];
}
/// To the global frame and back, axes column by column.
GRUS_INLINE void turn3(const double* axes, const double* v, double* to) {
  for (int k = 0; k < 3; ++k) to[k] = axes[k] * v[0] + axes[3 + k] * v[1] + axes[6 + k] * v[2];
}
GRUS_INLINE void turn_back3(const double* axes, const double* v, double* to) {
  for (int k = 0; k < 3; ++k) to[k] = dot3(axes + 3 * k, v);
}
GRUS_INLINE double largest3(const double* v) {
  double most = 0;
  for (int k = 0; k < 3; ++k) {
    const double size = v[k] < 0 ? -v[k] : v[k];
    most = size > most ? size : most;
  }
  return most;
}

/// Of A's surface within B, with phi = level + slope . x. Pressed: twice the integral of phi times the normal; 24 times
/// that of x phi with it. Spread: six times the first moment along the area vector, and plain; 24 times the second.
struct Faces {
  Sums force, moment, weighted, plain;
};

GRUS_INLINE void add_faces(const Triangles* t, int count, double level, const double* slope, const double* area,
                           Faces& sums) {
  const Real3 s{Real(slope[0]), Real(slope[1]), Real(slope[2])}, along{Real(area[0]), Real(area[1]), Real(area[2])};
  for (int at = 0; at < count; at += 8)
    for (int u = 0; u < parts; ++u) {
      const Lane3 k(t[at / 8], u * width);
      const Real3 sum = k.p + k.q + k.apex;
      const Real sp = dot(s, k.p), sq = dot(s, k.q), so = dot(s, k.apex), ss = sp + sq + so;
      sums.force.add(u, k.twice * fused(Real(1.0 / 3.0), ss, Real(level)), k.n);
      const Real3 first = fused(fused(Real(4.0), Real(level), ss), sum, fused(sp, k.p, fused(sq, k.q, so * k.apex)));
      sums.moment.add(u, k.twice, cross(first, k.n));
      sums.weighted.add(u, k.twice * dot(k.n, along), sum), sums.plain.add(u, k.twice, sum);
      sums.plain.w.r[u] =
          fused(k.twice, dot(sum, sum) + dot(k.p, k.p) + dot(k.q, k.q) + dot(k.apex, k.apex), sums.plain.w.r[u]);
    }
}

}  // namespace
}  // namespace grus::dem
