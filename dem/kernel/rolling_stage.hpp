// SPDX-License-Identifier: LGPL-3.0-or-later
// The stage of pairs whose rolling meets resistance: an elastic-plastic spring (Ai et al., Powder Technology 206 (2011)
// 269, type C) of stiffness k_t R_e^2, in three dimensions. The plain form is in contact/laws.hpp.
#pragma once

#include "dem/kernel/contact_chunk.hpp"

namespace grus::dem {
namespace {

/// The rolling spring, as the other one: turned with the contact, stretched by what the grains roll on each other by
/// the effective radius, up to its own limit.
template <Kind kind, bool attracts>
GRUS_STAGE void roll(const ContactRows& s, std::size_t first, int kept, Chunk& c, Sums& sums) {
  const Real dt(s.dt), half(0.5), zero(0.0), one(1.0);
  for (int g = 0; g < kept; ++g) {
    const int o = g * width, h = c.place(g, first), count = c.count[g];
    const std::size_t k = c.first[g];
    const Mask on = mask_of(c.touching[g]);
    const Real3 n{at(c.nx + o), at(c.ny + o), at(c.nz + o)};
    Real3 spin, of_b;
    Real unused;
    load4(s.motion + 8, s.a + k, 12, spin.x, spin.y, spin.z, unused);
    spin = Real(-1.0) * spin;
    if constexpr (kind != Kind::walls) {
      load4(s.motion + 8, s.b + k, 12, of_b.x, of_b.y, of_b.z, unused);
      spin = spin + of_b;
    }
    const Real radius = at(s.radius + k), kt = at(c.kt + o), before = at(c.before + o), after = at(c.compliance + o);
    const Real3 v = radius * less_fused(spin, dot(spin, n), n);
    const Real3 spring{at(s.roll_x + k), at(s.roll_y + k), at(s.roll_z + k)};
    const Real size2 = dot(spring, spring), size = root(size2);
    Real3 old = less_fused(spring, dot(n, spring), n);
    old = fused(at(c.turn + o), cross(n, old), old);
    const Real turned2 = dot(old, old), lost = smaller((size2 - turned2) / larger(turned2, Real(1e-290)), one);
    const Real keep = fused(lost, less_fused(half, Real(0.125), lost), one), grown = kt * before;
    Real3 now = less_fused((keep * smaller(one, grown)) * old, kt * dt, v);
    const Real limit = constant(s, law_rolling, k) * at((attracts ? c.borne : c.normal) + o), now2 = dot(now, now),
               reached = root(now2);
    const Mask gives = less(limit * limit, now2);
    const Real cut = select(gives, limit / reached, one), held = before * size2;
    const Real shed = held - smaller(held * grown, size2 * after);
    const Real rolled = fused(smaller(one, grown), size, limit) * (reached - limit) * after;
    sums.slid[h] = sums.slid[h] + kept_lanes(on, shed + select(gives, rolled, zero));
    const Real power = fused(cut, dot(now, v), keep * dot(old, v));
    sums.lost[h] = sums.lost[h] + kept_lanes(on, less_fused(less_fused(held, cut * cut, now2 * after), dt, power));
    now = cut * now;
    put_back(kept_lanes(on, now.x), count, s.roll_x + k);
    put_back(kept_lanes(on, now.y), count, s.roll_y + k);
    put_back(kept_lanes(on, now.z), count, s.roll_z + k);
    store(radius * now.x, c.mx + o);
    store(radius * now.y, c.my + o);
    store(radius * now.z, c.mz + o);
  }
}

}  // namespace
}  // namespace grus::dem
