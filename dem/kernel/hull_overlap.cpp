// SPDX-License-Identifier: LGPL-3.0-or-later
// Integrals over the boundary of the overlap: a face's are sums over its edges. Sums are kept in eight parts for every
// width, so that all give the same bits.
#include "dem/kernel/hull_edges.hpp"

namespace grus::dem {
namespace {

constexpr int parts = 8 / width;

GRUS_INLINE double sum_of(const Real (&r)[parts]) {
  double v[8];
  for (int k = 0; k < parts; ++k) store(r[k], v + k * width);
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

/// Eight borders' triangles with a corner of their face.
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

struct Sums3 {
  Real x[parts], y[parts], z[parts];
  GRUS_INLINE Sums3() {
    for (int k = 0; k < parts; ++k) x[k] = y[k] = z[k] = Real(0.0);
  }
  GRUS_INLINE void add(int k, Real w, const Real3& v) {
    x[k] = fused(w, v.x, x[k]), y[k] = fused(w, v.y, y[k]), z[k] = fused(w, v.z, z[k]);
  }
  GRUS_INLINE void total(double* to, double scale) const {
    to[0] = scale * sum_of(x), to[1] = scale * sum_of(y), to[2] = scale * sum_of(z);
  }
};

struct Sum {
  Real r[parts];
  GRUS_INLINE Sum() {
    for (int k = 0; k < parts; ++k) r[k] = Real(0.0);
  }
};

/// Six times the volume, 24 times its first moment, twice the area vector.
struct Solid {
  Sum volume;
  Sums3 first, area;
};

GRUS_INLINE void add_triangles(const Body& body, Borders& b, const Points& points, const Real3& origin, Triangles* t,
                               Solid& solid) {
  for (int k = b.count; k % 8 != 0; ++k) b.from[k] = b.to[k] = b.apex[k] = b.face[k] = 0;
  for (int at = 0; at < b.count; at += 8)
    for (int u = 0; u < parts; ++u) {
      const int k = at + u * width;
      Real3 p, q, apex, n;
      Real offset, unused;
      load4(points.row, b.from + k, 4, p.x, p.y, p.z, unused), load4(points.row, b.to + k, 4, q.x, q.y, q.z, unused);
      load4(body.plane, b.face + k, 4, n.x, n.y, n.z, offset);
      load4(points.row, b.apex + k, 4, apex.x, apex.y, apex.z, unused);
      const Real height = offset - dot(n, origin), twice = dot(n, cross(p - apex, q - apex));
      p = p - origin, q = q - origin, apex = apex - origin;
      const Real moved = height * twice;
      solid.volume.r[u] = solid.volume.r[u] + moved;
      solid.first.add(u, moved, p + q + apex);
      solid.area.add(u, twice, n);
      Triangles& to = t[at / 8];
      const int lane = u * width;
      store3(p, to.p, lane), store3(q, to.q, lane), store3(apex, to.apex, lane);
      store3(n, to.n, lane), store(twice, to.twice + lane);
    }
}

/// The plane that `x` is least deep below: its normal and offset.
GRUS_INLINE void find_shallowest(const HullColumns& h, const double* x, double* plane) {
  double depth[most_faces];
  const double* s = h.side;
  for (int f = 0; f < h.space; f += width) {
    Real nx, ny, nz, d;
    load(s + f, nx), load(s + h.space + f, ny), load(s + 2 * h.space + f, nz), load(s + 3 * h.space + f, d);
    store(less_fused(less_fused(less_fused(d, nx, x[0]), ny, x[1]), nz, x[2]), depth + f);
  }
  int best = 0;
  double least = depth[0];
  for (int f = 1; f < h.faces; ++f) {
    const bool closer = depth[f] < least;
    best = closer ? f : best, least = closer ? depth[f] : least;
  }
  for (int k = 0; k < 4; ++k) plane[k] = s[k * h.space + best];
}

GRUS_INLINE double dot3(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
GRUS_INLINE void cross3(const double* a, const double* b, double* to) {
  to[0] = a[1] * b[2] - a[2] * b[1], to[1] = a[2] * b[0] - a[0] * b[2], to[2] = a[0] * b[1] - a[1] * b[0];
}

/// Twice the integral of phi = level + slope.x times the normal over B's faces, and 24 times that of x phi with it.
GRUS_INLINE void press(const Triangles* t, int count, double level, const double* slope, double* force,
                       double* moment) {
  const Real3 s{Real(slope[0]), Real(slope[1]), Real(slope[2])};
  Sums3 forces, moments;
  for (int at = 0; at < count; at += 8)
    for (int u = 0; u < parts; ++u) {
      const Lane3 k(t[at / 8], u * width);
      const Real3 sum = k.p + k.q + k.apex;
      const Real sp = dot(s, k.p), sq = dot(s, k.q), so = dot(s, k.apex), ss = sp + sq + so;
      forces.add(u, k.twice * fused(Real(1.0 / 3.0), ss, Real(level)), k.n);
      const Real3 first = fused(fused(Real(4.0), Real(level), ss), sum, fused(sp, k.p, fused(sq, k.q, so * k.apex)));
      moments.add(u, k.twice, cross(first, k.n));
    }
  forces.total(force, 1), moments.total(moment, 1);
}

/// About A's surface within B: six times its first moment along the area vector, and plain; 24 times its second.
GRUS_INLINE void spread(const Triangles* t, int count, const double* area, double* middle, double* first,
                        double& second) {
  const Real3 along{Real(area[0]), Real(area[1]), Real(area[2])};
  Sums3 weighted, plain;
  Sum squares;
  for (int at = 0; at < count; at += 8)
    for (int u = 0; u < parts; ++u) {
      const Lane3 k(t[at / 8], u * width);
      const Real3 sum = k.p + k.q + k.apex;
      weighted.add(u, k.twice * dot(k.n, along), sum), plain.add(u, k.twice, sum);
      squares.r[u] = fused(k.twice, dot(sum, sum) + dot(k.p, k.p) + dot(k.q, k.q) + dot(k.apex, k.apex), squares.r[u]);
    }
  weighted.total(middle, 1), plain.total(first, 1), second = sum_of(squares.r);
}

}  // namespace

namespace GRUS_LANES {

Meets hull_overlap(const HullColumns& ha, const HullColumns& hb, const HullPose& pose, HullWrench& out) {
  double along_a[most_corners], along_b[most_corners], back[3];
  const double *n = pose.search, *turn = pose.turn, *shift = pose.shift;
  for (int k = 0; k < 3; ++k) back[k] = turn[k] * n[0] + turn[3 + k] * n[1] + turn[6 + k] * n[2];
  const double highest = project(ha, n, 0, 1, along_a), lowest = project(hb, back, dot3(n, shift), -1, along_b);
  if (highest <= lowest) return Meets::parted;
  double corner[3][most_corners];
  for (int v = 0; v < hb.room; v += width) {
    Real x, y, z;
    load(hb.corner + v, x), load(hb.corner + hb.room + v, y), load(hb.corner + 2 * hb.room + v, z);
    for (int k = 0; k < 3; ++k)
      store(fused(z, turn[3 * k + 2], fused(y, turn[3 * k + 1], fused(x, turn[3 * k], shift[k]))), corner[k] + v);
  }
  Body a, b;
  a.hull = &ha, a.x = ha.corner, a.y = ha.corner + ha.room, a.z = ha.corner + 2 * ha.room;
  b.hull = &hb, b.x = corner[0], b.y = corner[1], b.z = corner[2];
  const double size = highest < 0 ? -highest : highest;
  const double slack = pose.flush * (size + __builtin_sqrt(dot3(shift, shift)));
  find_near(a, along_a, lowest - slack, 1), find_near(b, along_b, highest + slack, -1);
  take_planes(a, b, pose);
  find_beyond(a, b, slack), find_beyond(b, a, -slack);

  Points points;
  Borders of_a(a.faces), of_b(b.faces);
  Lines lines;
  const int crossings = a.faces * b.faces;
  for (int k = 0; k < crossings; ++k) lines.from[k] = lines.to[k] = none;
  keep_edges<true>(a, b, points, of_a, lines), keep_edges<false>(b, a, points, of_b, lines);
  if (points.count == 0) return Meets::apart;
  if (!join_lines(lines, b.faces, of_a, of_b)) return Meets::unsettled;

  const double* const o = points.row;  // all that follows is about this point of K
  const Real3 origin{Real(o[0]), Real(o[1]), Real(o[2])};
  Triangles triangles_a[most_borders / 8 + 1], triangles_b[most_borders / 8 + 1];
  Solid solid;
  add_triangles(b, of_b, points, origin, triangles_b, solid);
  solid.area = Sums3();
  add_triangles(a, of_a, points, origin, triangles_a, solid);
  const double volume = sum_of(solid.volume.r) / 6;
  solid.area.total(out.area, 0.5);
  const double area2 = dot3(out.area, out.area);
  if (!(volume > 0 && volume * volume > pose.thin * pose.thin * slack * slack * area2)) return Meets::apart;
  double centre[3], x[3], y[3], i[4], j[4], j_body[4];
  solid.first.total(centre, 1 / (24 * volume));
  for (int k = 0; k < 3; ++k) x[k] = o[k] + centre[k], y[k] = x[k] - shift[k];
  find_shallowest(ha, x, i);
  const double in_b[3] = {turn[0] * y[0] + turn[3] * y[1] + turn[6] * y[2],
                          turn[1] * y[0] + turn[4] * y[1] + turn[7] * y[2],
                          turn[2] * y[0] + turn[5] * y[1] + turn[8] * y[2]};
  find_shallowest(hb, in_b, j_body);
  for (int k = 0; k < 3; ++k) j[k] = turned(turn + 3 * k, j_body[0], j_body[1], j_body[2]);
  j[3] = j_body[3] + dot3(j, shift);
  const double slope[3] = {-(i[0] + j[0]), -(i[1] + j[1]), -(i[2] + j[2])};
  const double level = i[3] + j[3] + dot3(slope, o), depth = level + dot3(slope, centre);

  double force[3], moment[3], first[3], second, weighted[3], of_j[3];
  press(triangles_b, of_b.count, level, slope, force, moment);
  cross3(centre, j, of_j);
  for (int k = 0; k < 3; ++k) out.force[k] = -0.5 * (0.5 * force[k] + volume * j[k]);
  cross3(o, out.force, out.moment);
  for (int k = 0; k < 3; ++k) out.moment[k] -= 0.5 * (moment[k] / 24 + volume * of_j[k]);
  double flat = 0;
  spread(triangles_a, of_a.count, out.area, weighted, first, second);
  for (int k = 0; k < of_a.count; ++k) flat += triangles_a[k / 8].twice[k % 8];
  double middle[3];
  for (int k = 0; k < 3; ++k) middle[k] = weighted[k] / (6 * (area2 > 1e-300 ? area2 : 1e-300));
  out.polar = second / 24 - dot3(middle, first) / 3 + 0.5 * flat * dot3(middle, middle);
  for (int k = 0; k < 3; ++k) out.middle[k] = o[k] + middle[k];
  out.volume = volume, out.energy = 0.5 * volume * depth;
  return Meets::overlaps;
}

}  // namespace GRUS_LANES
}  // namespace grus::dem
