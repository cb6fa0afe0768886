// SPDX-License-Identifier: LGPL-3.0-or-later
// The stages that all kinds of pairs go through, `chunk` pairs at a time. Only for the files that are built once for each
// instruction set.
#pragma once

#include "dem/kernel/contact_pass.hpp"
#include "dem/kernel/lanes.hpp"

namespace grus::dem {
namespace {

#define GRUS_STAGE [[gnu::noinline]] static

enum class Kind { spheres, walls, shaped };  // sphere on sphere, sphere on wall, pairs whose points of contact are given

constexpr int group = 8;   // contacts whose energies are summed apart: the same sums for any width
constexpr int chunk = 64;  // pairs that go through the stages together: short chains of operations, many at a time

/// What a chunk hands from stage to stage; columns of `chunk` values, in the order of the kept groups.
struct alignas(64) Chunk {
  double dx[chunk], dy[chunk], dz[chunk], ra[chunk], rb[chunk], gap[chunk];  // gap: squared distance, then overlap
  double drag_x[chunk], drag_y[chunk], drag_z[chunk];  // of the wall or the cell
  double sx[chunk], sy[chunk], sz[chunk], k[chunk], m[chunk], c[chunk], v[chunk], r[chunk];
  double distance[chunk], depth[chunk], root_depth[chunk], elastic[chunk], kt[chunk], inverse[chunk], inverse_kt[chunk], dashpot[chunk], friction[chunk];
  double arm_ax[chunk], arm_ay[chunk], arm_az[chunk], arm_bx[chunk], arm_by[chunk], arm_bz[chunk];  // shaped pairs
  double keep[chunk], cut[chunk], held[chunk], old_work[chunk];
  double vx[chunk], vy[chunk], vz[chunk], turn[chunk], normal[chunk];  // velocity of b against a, mean spin along n, normal force
  std::size_t first[chunk / width];   // pair of each kept group
  unsigned touching[chunk / width];
  int count[chunk / width];

  /// Where the energies of kept group g are summed, in a call that began at pair `begin`.
  int place(int g, std::size_t begin) const { return static_cast<int>((first[g] - begin) / width % (group / width)); }
};

GRUS_INLINE Real at(const double* column) {
  Real x;
  load(column, x);
  return x;
}

/// Energy (J) that the spring of a parting pair still held.
GRUS_INLINE double part(double* contact) {
  const double held = 0.5 * contact[5] * (contact[0] * contact[0] + contact[1] * contact[1] + contact[2] * contact[2]);
  for (int k = 0; k < 8; ++k) contact[k] = k == 4 ? contact[4] : 0;  // the effective mass is the pair's
  return held;
}

// Roots take long, and a processor looks only some hundred operations ahead: each loop below ends in one, so that many
// are under way together.

/// Overlap, elastic force and stiffness.
template <Kind kind, bool hertz, bool friction, bool dashpot>
GRUS_STAGE void respond(const ContactRows& s, int kept, Chunk& c) {
  const Real one(1.0), zero(0.0);
  if constexpr (kind == Kind::spheres)
    for (int o = 0; o < kept * width; o += width) {
      const Real d2 = at(c.gap + o), y = inverse_root(d2);
      store(y, c.inverse + o), store(d2 * y, c.distance + o);
    }
  for (int g = 0; g < kept; ++g) {
    const int o = g * width;
    if constexpr (kind == Kind::spheres) {
      const Real distance = at(c.distance + o);
      const Mask coincide = less(distance, Real(1e-150));
      store(at(c.ra + o) + at(c.rb + o) - distance, c.gap + o);
      if (bits(coincide)) {  // centres that coincide have no direction
        store(select(coincide, one, at(c.dx + o)), c.dx + o), store(select(coincide, zero, at(c.dy + o)), c.dy + o);
        store(select(coincide, zero, at(c.dz + o)), c.dz + o), store(select(coincide, one, at(c.inverse + o)), c.inverse + o);
      }
    }
    // A pair can touch by less than the round-off of its distance: never let its depth be 0 or less.
    const Mask on = mask_of(c.touching[g]);
    const Real gap = at(c.gap + o), positive = larger(gap, Real(1e-30)), depth = select(on, positive, one);
    store(select(on, positive, gap), c.gap + o), store(depth, c.depth + o);
    if constexpr (hertz) store(root(depth), c.root_depth + o);
  }
  for (int g = 0; g < kept; ++g) {
    const int o = g * width;
    const double* const history = s.contact + 8 * c.first[g];
    Real3 spring;
    Real stiffness, mass, compliance, viscous, radius;
    load4(history, 8, spring.x, spring.y, spring.z, stiffness);
    load4(history + 4, 8, mass, compliance, viscous, radius);
    auto column = [&](int k) { return s.law_count == 1 ? Real(s.laws[k]) : gather(s.laws + k, s.law + c.first[g], law_columns); };
    const Real ks = hertz ? stiffness * at(c.root_depth + o) : stiffness, normal_stiffness = hertz ? Real(1.5) * ks : stiffness;
    if constexpr (friction) {
      const Real kt = select(mask_of(c.touching[g]), column(law_shear_ratio) * normal_stiffness, one);
      store(kt, c.kt + o), store(inverse(kt), c.inverse_kt + o), store(column(law_friction), c.friction + o);
    }
    if constexpr (dashpot) {
      const Real x = mass * normal_stiffness;
      store(column(law_dashpot) * root(x), c.dashpot + o);
    }
    store(ks * at(c.depth + o), c.elastic + o);
    store(spring.x, c.sx + o), store(spring.y, c.sy + o), store(spring.z, c.sz + o), store(stiffness, c.k + o);
    store(mass, c.m + o), store(compliance, c.c + o), store(viscous, c.v + o), store(radius, c.r + o);
  }
}

/// Normal, velocity of b against a where they touch, and their mean spin along the normal.
template <Kind kind>
GRUS_STAGE void meet(const ContactRows& s, int kept, Chunk& c) {
  const Real half(0.5);
  for (int g = 0; g < kept; ++g) {
    const int o = g * width;
    const std::uint32_t *ia = s.a + c.first[g], *ib = s.b + c.first[g];
    Real3 va, wa, drag;
    Real unused;
    load4(s.motion + 4, ia, 12, va.x, va.y, va.z, unused);
    load4(s.motion + 8, ia, 12, wa.x, wa.y, wa.z, unused);
    Real3 n{at(c.dx + o), at(c.dy + o), at(c.dz + o)};
    if constexpr (kind == Kind::spheres) {
      n = at(c.inverse + o) * n;
      store(n.x, c.dx + o), store(n.y, c.dy + o), store(n.z, c.dz + o);
    }
    Real3 v;
    if constexpr (kind == Kind::walls) {
      const Real la = less_fused(at(c.ra + o), half, at(c.gap + o));
      store(la, c.ra + o);
      load4(s.walls + 4, s.target + c.first[g], 8, drag.x, drag.y, drag.z, unused);
      v = drag - va - cross(la * wa, n);
      store(half * dot(n, wa), c.turn + o);
    } else {
      Real3 vb, wb;
      load4(s.motion + 4, ib, 12, vb.x, vb.y, vb.z, unused);
      load4(s.motion + 8, ib, 12, wb.x, wb.y, wb.z, unused);
      if constexpr (kind == Kind::spheres) {
        const Real overlap = at(c.gap + o), la = less_fused(at(c.ra + o), half, overlap), lb = less_fused(at(c.rb + o), half, overlap);
        store(la, c.ra + o), store(lb, c.rb + o);
        v = vb - va - cross(fused(la, wa, lb * wb), n);
      } else {
        const Real3 arm_a{at(c.arm_ax + o), at(c.arm_ay + o), at(c.arm_az + o)}, arm_b{at(c.arm_bx + o), at(c.arm_by + o), at(c.arm_bz + o)};
        v = vb - va + cross(wb, arm_b) - cross(wa, arm_a);
      }
      store(half * dot(n, wa + wb), c.turn + o);
      if (s.shift) {
        load4(s.shifts + 4, s.shift + c.first[g], 8, drag.x, drag.y, drag.z, unused);
        v = v + drag;
      }
    }
    if (kind == Kind::walls || s.shift) store(drag.x, c.drag_x + o), store(drag.y, c.drag_y + o), store(drag.z, c.drag_z + o);
    store(v.x, c.vx + o), store(v.y, c.vy + o), store(v.z, c.vz + o);
  }
}

/// Sums of one call, one for each of `group` places.
struct Sums {
  Real slid[group / width], spent[group / width], power[group / width];
};

/// Dashpot; spring turned with the contact and stretched by the slip, and its Coulomb limit.
template <bool friction, bool dashpot>
GRUS_STAGE void resist(const ContactRows& s, std::size_t first, int kept, Chunk& c, Sums& sums) {
  const Real dt(s.dt), half(0.5), zero(0.0), one(1.0);
  for (int g = 0; g < kept; ++g) {
    const int o = g * width, h = c.place(g, first);
    const Real3 n{at(c.dx + o), at(c.dy + o), at(c.dz + o)}, v{at(c.vx + o), at(c.vy + o), at(c.vz + o)};
    const Real vn = dot(v, n), elastic = at(c.elastic + o);
    Real normal = elastic;
    if constexpr (dashpot) {
      const Real viscous = larger(zero - at(c.dashpot + o) * vn, zero - elastic);  // no attraction
      sums.spent[h] = sums.spent[h] - kept_lanes(mask_of(c.touching[g]), half * (at(c.v + o) + viscous) * vn * dt);
      normal = elastic + viscous;
      store(viscous, c.v + o);
    }
    store(normal, c.normal + o);
    if constexpr (friction) {
      const Real3 slip = dt * less_fused(v, vn, n);
      store(slip.x, c.vx + o), store(slip.y, c.vy + o), store(slip.z, c.vz + o);
      const Real3 spring{at(c.sx + o), at(c.sy + o), at(c.sz + o)};
      const Real size2 = dot(spring, spring), compliance = at(c.c + o);
      store(half * compliance * size2, c.held + o);
      Real3 old = less_fused(spring, dot(n, spring), n);
      old = fused(at(c.turn + o) * dt, cross(n, old), old);
      store(old.x, c.sx + o), store(old.y, c.sy + o), store(old.z, c.sz + o);
      // Turned with the contact, not shortened: by sqrt(size2 / turned2), to third order in what the turn took.
      const Real turned2 = dot(old, old), lost = smaller((size2 - turned2) * inverse(larger(turned2, Real(1e-290)), 2), one);
      store(fused(lost, less_fused(half, Real(0.125), lost), one), c.keep + o);
    }
  }
  if constexpr (friction)
    for (int g = 0; g < kept; ++g) {
      const int o = g * width;
      const Real kt = at(c.kt + o), keep = at(c.keep + o);
      const Real3 old{keep * at(c.sx + o), keep * at(c.sy + o), keep * at(c.sz + o)}, slip{at(c.vx + o), at(c.vy + o), at(c.vz + o)};
      const Real3 now = less_fused(smaller(one, kt * at(c.c + o)) * old, kt, slip);
      store(half * dot(old, slip), c.old_work + o);
      store(now.x, c.sx + o), store(now.y, c.sy + o), store(now.z, c.sz + o);
      const Real limit = at(c.friction + o) * at(c.normal + o), now2 = dot(now, now);
      const Mask slides = less(limit * limit, now2);
      store(select(slides, limit * inverse_root(now2), one), c.cut + o);
    }
}

/// Histories back to their rows, forces to the grains' loads.
template <Kind kind, bool friction, bool dashpot>
GRUS_STAGE void hand_out(const ContactRows& s, std::size_t first, int kept, Chunk& c, Sums& sums) {
  const Real zero(0.0);
  for (int g = 0; g < kept; ++g) {
    const int o = g * width, h = c.place(g, first);
    const std::size_t k = c.first[g];
    const unsigned touching = c.touching[g];
    const Real3 n{at(c.dx + o), at(c.dy + o), at(c.dz + o)};
    Real3 now{zero, zero, zero}, twist{zero, zero, zero};
    if constexpr (friction) {
      const Real cut = at(c.cut + o), half(0.5);
      now = {cut * at(c.sx + o), cut * at(c.sy + o), cut * at(c.sz + o)};
      twist = cross(now, n);
      const Real3 slip{at(c.vx + o), at(c.vy + o), at(c.vz + o)};
      const Real remains = half * at(c.inverse_kt + o) * dot(now, now), work = fused(half, dot(now, slip), at(c.old_work + o));
      sums.slid[h] = sums.slid[h] + kept_lanes(mask_of(touching), at(c.held + o) - remains - work);
    }
    const Real3 force = fused(at(c.normal + o), n, now);
    if (kind == Kind::walls || s.shift) {
      const Real3 drag{at(c.drag_x + o), at(c.drag_y + o), at(c.drag_z + o)};
      sums.power[h] = sums.power[h] + kept_lanes(mask_of(touching), dot(force, drag));
    }
    if constexpr (friction || dashpot) {
      const Rows history = rows(quads(now.x, now.y, now.z, at(c.k + o)), quads(at(c.m + o), friction ? at(c.inverse_kt + o) : zero, at(c.v + o), at(c.r + o)));
#pragma GCC unroll 8
      for (int l = 0; l < width; ++l)
        if (touching >> l & 1) put(history, l, s.contact + 8 * (k + static_cast<std::size_t>(l)));
    }
    const Quads push = quads(force.x, force.y, force.z, zero);
    Real3 torque_a, torque_b;  // minus what a feels, what b feels
    if constexpr (kind == Kind::shaped) {
      torque_a = cross(Real3{at(c.arm_ax + o), at(c.arm_ay + o), at(c.arm_az + o)}, force);
      torque_b = cross(Real3{at(c.arm_bx + o), at(c.arm_by + o), at(c.arm_bz + o)}, force);
    } else {
      torque_a = (zero - at(c.ra + o)) * twist;
      if constexpr (kind == Kind::spheres) torque_b = at(c.rb + o) * twist;
    }
    const Rows on_a = rows(push, quads(torque_a.x, torque_a.y, torque_a.z, zero));
    if constexpr (kind == Kind::walls) {
      for (int l = 0; l < width; ++l)
        if (touching >> l & 1) subtract(on_a, l, s.load + 8 * std::size_t{s.a[k + static_cast<std::size_t>(l)]});
    } else {
      const Rows on_b = rows(push, quads(torque_b.x, torque_b.y, torque_b.z, zero));
#pragma GCC unroll 8
      for (int l = 0; l < width; ++l)
        if (touching >> l & 1) {
          subtract(on_a, l, s.load + 8 * std::size_t{s.a[k + static_cast<std::size_t>(l)]});
          const std::uint32_t target = s.target[k + static_cast<std::size_t>(l)];
          add(on_b, l, (target < s.grains ? s.load : s.elsewhere) + 8 * std::size_t{target});
        }
    }
    if (s.touch) {
      const Mask on = mask_of(touching);
      const Rows seen = rows(quads(n.x, n.y, n.z, at(c.gap + o)), quads(kept_lanes(on, force.x), kept_lanes(on, force.y), kept_lanes(on, force.z), zero));
      for (int l = 0; l < c.count[g]; ++l)
        if (kind != Kind::shaped || (touching >> l & 1)) put(seen, l, s.touch + 8 * (k + static_cast<std::size_t>(l)));
    }
  }
}

/// The stage before all others: which pairs of [first, last) touch; how many groups are kept. For spheres and walls: vector
/// between the centres and its square, or normal and overlap; for shaped pairs normal, overlap and arms.
template <Kind kind>
int find_touching(const ContactRows& s, std::size_t first, std::size_t last, Chunk& c, double& parted);

template <Kind kind, bool hertz, bool friction, bool dashpot>
PassEnergy run(const ContactRows& s, std::size_t first, std::size_t last) {
  Sums sums;
  for (int h = 0; h < group / width; ++h) sums.slid[h] = sums.spent[h] = sums.power[h] = Real(0.0);
  PassEnergy e;
  Chunk c;
  for (std::size_t start = first; start < last; start += chunk) {
    const int kept = find_touching<kind>(s, start, last - start < chunk ? last : start + chunk, c, e.friction);
    respond<kind, hertz, friction, dashpot>(s, kept, c);
    meet<kind>(s, kept, c);
    resist<friction, dashpot>(s, first, kept, c, sums);
    hand_out<kind, friction, dashpot>(s, first, kept, c, sums);
  }
  for (int h = 0; h < group / width; ++h) {
    double x[width], y[width], z[width];
    store(sums.slid[h], x), store(sums.spent[h], y), store(sums.power[h], z);
    for (int l = 0; l < width; ++l) e.friction += x[l], e.viscous += y[l], e.power += z[l];
  }
  return e;
}

template <Kind kind>
PassEnergy choose(const ContactRows& s, std::size_t first, std::size_t last) {
  if (s.hertz) {
    if (s.friction) return s.dashpot ? run<kind, true, true, true>(s, first, last) : run<kind, true, true, false>(s, first, last);
    return s.dashpot ? run<kind, true, false, true>(s, first, last) : run<kind, true, false, false>(s, first, last);
  }
  if (s.friction) return s.dashpot ? run<kind, false, true, true>(s, first, last) : run<kind, false, true, false>(s, first, last);
  return s.dashpot ? run<kind, false, false, true>(s, first, last) : run<kind, false, false, false>(s, first, last);
}

}  // namespace
}  // namespace grus::dem
