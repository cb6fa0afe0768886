// SPDX-License-Identifier: LGPL-3.0-or-later
// Pairs of grains of which one is not a sphere: the search of shape/common_normal.cpp for many pairs at once. What does
// not go the usual way (new contacts, folds, directions that wander) is settled one by one by ContactRows::solve.
#include "dem/kernel/contact_stages.hpp"

namespace grus::dem {
namespace {

/// Poses and shapes of a group of grains, one side of the pairs.
struct Bodies {
  Real3 origin, ex, ey, ez;  // axes of the geometry frame
  Real3 plus, minus;

  GRUS_INLINE void read(const ContactRows& s, const std::uint32_t* at) {
    load4(s.frame, at, 12, origin.x, origin.y, origin.z, ex.x);
    load4(s.frame + 4, at, 12, ex.y, ex.z, ey.x, ey.y);
    load4(s.frame + 8, at, 12, ey.z, ez.x, ez.y, ez.z);
    Real again;
    load4(s.shape, at, 6, plus.x, plus.y, plus.z, minus.x);
    load4(s.shape + 2, at, 6, again, again, minus.y, minus.z);
  }
  GRUS_INLINE Real3 local(const Real3& v) const { return {dot(ex, v), dot(ey, v), dot(ez, v)}; }
  GRUS_INLINE Real3 global(const Real3& v) const { return fused(v.z, ez, fused(v.y, ey, v.x * ex)); }
  GRUS_INLINE Real3 squares(const Real3& d) const {  // of the octant of d
    const Real zero(0.0);
    const Real3 a{select(less(d.x, zero), minus.x, plus.x), select(less(d.y, zero), minus.y, plus.y),
                  select(less(d.z, zero), minus.z, plus.z)};
    return {a.x * a.x, a.y * a.y, a.z * a.z};
  }
};

/// One side of f(n) = h_A(n) + h_B(-n) - n.r: support height and point in the direction d (geometry frame).
struct Side {
  Real3 squares, point;
  Real height, inverse_height;

  GRUS_INLINE Side(const Bodies& body, const Real3& d) : squares(body.squares(d)) {
    point = {squares.x * d.x, squares.y * d.y, squares.z * d.z};
    const Real h2 = dot(point, d);
    inverse_height = inverse_root(h2);
    height = h2 * inverse_height;
    point = inverse_height * point;
  }
  GRUS_INLINE Real3 hessian(const Real3& v) const {
    const Real along = dot(point, v);
    return inverse_height * less_fused(Real3{squares.x * v.x, squares.y * v.y, squares.z * v.z}, along, point);
  }
  GRUS_INLINE Real trace() const { return inverse_height * (squares.x + squares.y + squares.z - dot(point, point)); }
};

struct Evaluation {
  Side a, b;
  Real3 point_a, point_b, g;  // support points from the octant origin of A (global); tangential gradient
  Real f;

  GRUS_INLINE Evaluation(const Bodies& A, const Bodies& B, const Real3& r, const Real3& n)
      : a(A, A.local(n)), b(B, B.local(Real(-1.0) * n)) {
    point_a = A.global(a.point), point_b = r + B.global(b.point);
    const Real3 w = point_a - point_b;
    f = dot(w, n);
    g = less_fused(w, f, n);
  }
};

/// Newton by Cayley and Hamilton, as in shape/common_normal.cpp; says where the Hessian is positive definite.
GRUS_INLINE unsigned newton_step(const Bodies& A, const Bodies& B, const Evaluation& e, Real3& step) {
  const Real g2 = dot(e.g, e.g), tiny(1e-300);
  const Real3 mg = less_fused(A.global(e.a.hessian(A.local(e.g))) + B.global(e.b.hessian(B.local(e.g))), e.f, e.g);
  const Real t = e.a.trace() + e.b.trace() - Real(2.0) * e.f;
  const Real det = fused_less(dot(e.g, mg), t, dot(mg, mg)) * inverse(larger(g2, tiny));
  const unsigned good = bits(less(Real(0.0), t)) & bits(less(Real(1e-12) * t * t, det));
  step = inverse(larger(det, tiny)) * less_fused(mg, t, e.g);
  return good;
}

GRUS_INLINE Real3 chosen(Mask m, const Real3& a, const Real3& b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}

/// Columns of a group that all stages after the first read.
GRUS_INLINE void put_columns(Chunk& c, int o, const Real3& n, Real overlap, const Real3& arm_a, const Real3& arm_b) {
  store(n.x, c.nx + o);
  store(n.y, c.ny + o);
  store(n.z, c.nz + o);
  store(overlap, c.overlap + o);
  store(arm_a.x, c.arm_ax + o);
  store(arm_a.y, c.arm_ay + o);
  store(arm_a.z, c.arm_az + o);
  store(arm_b.x, c.arm_bx + o);
  store(arm_b.y, c.arm_by + o);
  store(arm_b.z, c.arm_bz + o);
}

template <Kind kind, bool attracts>
[[gnu::noinline]] int find_touching(const ContactRows& s, std::size_t first, std::size_t last, std::size_t& next,
                                    Chunk& c, double&) {
  int kept = 0;
  std::size_t k = next;
  for (; k < last && kept < chunk / width; k += width) {
    double* const until = s.until ? s.until + (k - first) / width : nullptr;
    if (until && s.way < *until) continue;
    const int count = last - k < width ? static_cast<int>(last - k) : width, o = kept * width;
    const std::uint32_t *ia = s.a + k, *ib = s.b + k;
    const unsigned valid = (1u << count) - 1, before = flags(s.active + k) & valid;
    Bodies A, B;
    A.read(s, ia), B.read(s, ib);
    Real3 r = B.origin - A.origin, offset, n;
    Real unused, scale;
    if (s.shift) {
      load4(s.shifts, s.shift + k, 8, offset.x, offset.y, offset.z, unused);
      r = r + offset;
    }
    load4(s.touch + 8 * k, 8, n.x, n.y, n.z, unused);
    if (before == 0) {  // the common case of near pairs that stay apart: one direction that parts them
      const Side a(A, A.local(n)), b(B, B.local(Real(-1.0) * n));
      const Real depth = a.height + b.height - dot(n, r);
      if ((bits(less(depth, Real(0.0))) & valid) == valid) {
        // Until the gap along this direction is used up it parts them: they would be left as they are.
        if (until) *until = s.way + (least_of(select(mask_of(valid), Real(0.0) - depth, Real(1e300))) - s.blur);
        continue;
      }
    }
    scale = A.plus.x + A.minus.x + B.plus.x + B.minus.x;
    const Real enough = Real(1e-12) * scale * scale;  // as in shape/common_normal.cpp
    Evaluation e(A, B, r, n);
    unsigned done = 0, hard = 0;
    for (int round = 0;; ++round) {
      done |= (bits(less(dot(e.g, e.g), enough)) | bits(less(e.f, Real(0.0)))) & ~hard;
      const unsigned open = valid & ~done & ~hard;
      if (!open) break;
      if (round == 5) {
        hard |= open;
        break;
      }
      Real3 step;
      const unsigned good = newton_step(A, B, e, step) & bits(less(dot(step, step), Real(0.09)));
      Real3 further = n + step;
      further = inverse_root(dot(further, further)) * further;
      const Evaluation trial(A, B, r, further);
      const unsigned moved = open & good & ~bits(less(e.f + Real(1e-12) * scale, trial.f));
      hard |= open & ~moved;
      const Mask m = mask_of(moved);
      n = chosen(m, further, n);
      e.point_a = chosen(m, trial.point_a, e.point_a);
      e.point_b = chosen(m, trial.point_b, e.point_b);
      e.g = chosen(m, trial.g, e.g);
      e.f = select(m, trial.f, e.f);
      e.a.squares = chosen(m, trial.a.squares, e.a.squares), e.a.point = chosen(m, trial.a.point, e.a.point);
      e.b.squares = chosen(m, trial.b.squares, e.b.squares), e.b.point = chosen(m, trial.b.point, e.b.point);
      e.a.inverse_height = select(m, trial.a.inverse_height, e.a.inverse_height);
      e.b.inverse_height = select(m, trial.b.inverse_height, e.b.inverse_height);
    }
    const unsigned meet = bits(less(Real(0.0), e.f)) & done & valid;
    unsigned touching = meet & before;

    Real3 xa, xb;
    load4(s.motion, ia, 12, xa.x, xa.y, xa.z, unused);
    load4(s.motion, ib, 12, xb.x, xb.y, xb.z, unused);
    if (s.shift) xb = xb + offset;
    const Real3 point = fused(Real(0.5), e.point_a + e.point_b, A.origin);
    put_columns(c, o, n, e.f, point - xa, point - xb);
    // One by one: what begins, what ends, what Newton does not settle.
    for (unsigned m = valid & (hard | (meet & ~before) | (before & ~meet)); m; m &= m - 1) {
      const int l = __builtin_ctz(m);
      const std::size_t p = k + static_cast<std::size_t>(l);
      double found[7];  // normal, overlap, point
      if (!s.solve(s.context, p, found)) continue;
      touching |= 1u << l;
      const double *ma = s.motion + 12 * std::size_t{s.a[p]}, *mb = s.motion + 12 * std::size_t{s.b[p]};
      const double* shift = s.shift ? s.shifts + 8 * std::size_t{s.shift[p]} : nullptr;
      double* const columns[10] = {c.nx,     c.ny,     c.nz,     c.overlap, c.arm_ax,
                                   c.arm_ay, c.arm_az, c.arm_bx, c.arm_by,  c.arm_bz};
      for (int j = 0; j < 4; ++j) columns[j][o + l] = found[j];
      for (int j = 0; j < 3; ++j) {
        columns[4 + j][o + l] = found[4 + j] - ma[j];
        columns[7 + j][o + l] = found[4 + j] - (shift ? mb[j] + shift[j] : mb[j]);
      }
    }
    // Directions of pairs that stay apart: the next search begins there.
    for (unsigned m = valid & ~touching & ~hard & ~before; m; m &= m - 1) {
      const int l = __builtin_ctz(m);
      double* const to = s.touch + 8 * (k + static_cast<std::size_t>(l));
      to[0] = c.nx[o + l];
      to[1] = c.ny[o + l];
      to[2] = c.nz[o + l];
    }
    if (touching == 0) continue;
    c.first[kept] = k;
    c.touching[kept] = touching;
    c.count[kept] = count;
    ++kept;
  }
  next = k;
  return kept;
}

}  // namespace

namespace GRUS_LANES {
PassEnergy polyellipsoid_pairs(const ContactRows& s, std::size_t first, std::size_t last) {
  return choose<Kind::shaped>(s, first, last);
}
}  // namespace GRUS_LANES

}  // namespace grus::dem
