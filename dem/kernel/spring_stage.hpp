// SPDX-License-Identifier: LGPL-3.0-or-later
// The elastic-plastic spring for several contacts at a time, and the stage of those that hold couples. The plain form
// is in contact/springs.hpp. Only for the files that are built once for each instruction set.
#pragma once

#include "dem/kernel/contact_chunk.hpp"

namespace grus::dem {
namespace {

/// A spring in the frame of its contact, which has turned: `old` is shorter than it was by `keep`.
struct Turned {
  Real3 old;
  Real keep;
};

/// `part`: of the spring, what stays as the normal turns to n; `size2`: of the whole. Not shortened: by
/// sqrt(size2 / turned2), to third order in what the turn took.
GRUS_INLINE Turned turn_spring(const Real3& part, Real size2, const Real3& n, Real angle) {
  const Real3 old = fused(angle, cross(n, part), part);
  const Real turned2 = dot(old, old), lost = smaller((size2 - turned2) / larger(turned2, Real(1e-290)), Real(1.0));
  return {old, fused(lost, less_fused(Real(0.5), Real(0.125), lost), Real(1.0))};
}

/// Compliance of the step before and of this one, stiffness of this one, largest force.
struct Grip {
  Real before, after, kt, limit;
};

/// A spring after its step, before its limit; cut * now is what it holds.
struct Stretched {
  Real3 now;
  Real cut;
};

/// The spring goes on at velocity v; `size`, `size2`: of its force before the step.
GRUS_INLINE Stretched stretch_spring(const Turned& t, const Grip& g, Real size, Real size2, const Real3& v, Real dt,
                                     Mask on, Real& slid, Real& lost) {
  const Real zero(0.0), one(1.0);
  const Real grown = g.kt * g.before;
  const Real3 now = less_fused((t.keep * smaller(one, grown)) * t.old, g.kt * dt, v);
  const Real now2 = dot(now, now);
  const Mask gives = less(g.limit * g.limit, now2);
  const Real reached = root(now2), cut = select(gives, g.limit / reached, one);
  // A spring sheds the smaller part of its stiffness or of its force; giving way takes the plastic slip times what held
  // against it, the spring at first and its limit at last.
  const Real held = g.before * size2, shed = held - smaller(held * grown, size2 * g.after);
  const Real plastic = fused(smaller(one, grown), size, g.limit) * (reached - g.limit) * g.after;
  slid = slid + kept_lanes(on, shed + select(gives, plastic, zero));
  const Real power = fused(cut, dot(now, v), t.keep * dot(t.old, v));
  lost = lost + kept_lanes(on, less_fused(less_fused(held, cut * cut, now2 * g.after), dt, power));
  return {now, cut};
}

/// What a couple's row answers: the part of a turn, or of a spring, that is its own.
struct RollRow {
  static constexpr SpringRow row = roll_spring;
  GRUS_INLINE static Real3 part(const Real3& of, const Real3& n) { return less_fused(of, dot(n, of), n); }
};

/// A spring that holds a couple: turned with the contact, stretched by its part of how b turns against a, up to its own
/// limit. `first`: no other couple acts on these pairs yet; `alone`: there is no other.
template <Kind kind, bool attracts, bool alone, class Row>
GRUS_STAGE void hold_couple(const ContactRows& s, std::size_t start, int kept, bool first, Chunk& c, Sums& sums) {
  double *const x = s.spring[Row::row][0], *const y = s.spring[Row::row][1], *const z = s.spring[Row::row][2];
  const Real dt(s.dt);
  for (int g = 0; g < kept; ++g) {
    const int o = g * width, h = c.place(g, start), count = c.count[g];
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
    const Real radius = at(s.radius + k);
    const Real3 held{at(x + k), at(y + k), at(z + k)};
    const Real size2 = dot(held, held);
    const Grip grip{at(c.before + o), at(c.compliance + o), at(c.kt + o),
                    constant(s, law_friction + std::size_t{Row::row}, k) * at((attracts ? c.borne : c.normal) + o)};
    const Stretched stretched =
        stretch_spring(turn_spring(Row::part(held, n), size2, n, at(c.turn + o)), grip, root(size2), size2,
                       radius * Row::part(spin, n), dt, on, sums.slid[h], sums.lost[h]);
    const Real3 now = stretched.cut * stretched.now;
    put_back(kept_lanes(on, now.x), count, x + k);
    put_back(kept_lanes(on, now.y), count, y + k);
    put_back(kept_lanes(on, now.z), count, z + k);
    Real3 couple = radius * now;
    if (!alone && !first) couple = couple + Real3{at(c.mx + o), at(c.my + o), at(c.mz + o)};
    store(couple.x, c.mx + o);
    store(couple.y, c.my + o);
    store(couple.z, c.mz + o);
  }
}

/// All couples that are kept, by their rows.
template <Kind kind, bool attracts, class... CoupleRows>
GRUS_INLINE void hold_each(const ContactRows& s, std::size_t start, int kept, Chunk& c, Sums& sums) {
  static_assert(sizeof...(CoupleRows) == spring_rows - first_couple);
  constexpr bool alone = sizeof...(CoupleRows) == 1;
  bool first = true;
  const auto hold = [&]<class Row>(Row) {
    if (!s.spring[Row::row][0]) return;
    hold_couple<kind, attracts, alone, Row>(s, start, kept, first, c, sums);
    first = false;
  };
  (hold(CoupleRows{}), ...);
}

template <Kind kind, bool attracts>
GRUS_INLINE void hold_couples(const ContactRows& s, std::size_t start, int kept, Chunk& c, Sums& sums) {
  hold_each<kind, attracts, RollRow>(s, start, kept, c, sums);
}

}  // namespace
}  // namespace grus::dem
