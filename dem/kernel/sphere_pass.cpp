// SPDX-License-Identifier: LGPL-3.0-or-later
// Spheres on spheres and on walls. Built once for each instruction set, with GRUS_LANES naming the namespace. Includes
// nothing that could leave a shared symbol behind: a machine must never run code of a wider target.
#include "dem/kernel/contact_stages.hpp"

namespace grus::dem {
namespace {

/// A pair that begins to touch: its stiffness is frozen here.
template <Kind kind>
[[gnu::noinline]] static void begin(const ContactRows& s, std::size_t p) {
  const double ra = s.motion[12 * std::size_t{s.a[p]} + 3];
  double r = ra;
  if constexpr (kind == Kind::spheres) {
    const double rb = s.motion[12 * std::size_t{s.b[p]} + 3];
    r = ra * rb / (ra + rb);
  }
  s.begin(s.context, p, r);
}

/// Which pairs touch. Groups without any are left out, unless somebody looks.
template <Kind kind, bool attracts>
[[gnu::noinline]] int find_touching(const ContactRows& s, std::size_t first, std::size_t last, Chunk& c,
                                    double& parted) {
  int kept = 0;
  for (std::size_t k = first; k < last; k += width) {
    const int count = last - k < width ? static_cast<int>(last - k) : width, o = kept * width;
    const std::uint32_t *ia = s.a + k, *ib = s.b + k;  // columns go on by `group` beyond their end
    if (kind == Kind::spheres && far(s)) ask_for_grains(s, k);
    Real3 xa, d;
    Real ra, rb, gap;
    load4(s.motion, ia, 12, xa.x, xa.y, xa.z, ra);
    unsigned touching;
    if constexpr (kind == Kind::walls) {
      Real offset;
      load4(s.walls, s.target + k, 8, d.x, d.y, d.z, offset);  // normal into the space
      gap = ra - (dot(d, xa) - offset);
      if (s.rounds) {
        Real3 from, axis;
        Real radius, none;
        load4(s.rounds, s.target + k, 8, from.x, from.y, from.z, radius);
        load4(s.rounds + 4, s.target + k, 8, axis.x, axis.y, axis.z, none);
        from = xa - from;
        from = from - dot(from, axis) * axis;
        const Real away = root(larger(dot(from, from), Real(1e-300)));
        const Mask round = less(Real(0.0), radius);
        const Real inward = Real(-1.0) / away;
        d = {select(round, inward * from.x, d.x), select(round, inward * from.y, d.y),
             select(round, inward * from.z, d.z)};
        gap = select(round, ra + away - radius, gap);
      }
      d = Real(-1.0) * d;
      touching = bits(less(attracts ? Real(-1.0) * at(s.reach + k) : Real(0.0), gap));
    } else {
      Real3 xb;
      load4(s.motion, ib, 12, xb.x, xb.y, xb.z, rb);
      d = xb - xa;
      if (s.shift) {
        Real3 offset;
        Real none;
        load4(s.shifts, s.shift + k, 8, offset.x, offset.y, offset.z, none);
        d = d + offset;
      }
      gap = dot(d, d);
      Real end = ra + rb;
      if constexpr (attracts) end = end + at(s.reach + k);  // of what touches
      touching = bits(less(gap, end * end));
    }
    touching &= (1u << count) - 1;
    const unsigned before = flags(s.active + k) & ((1u << count) - 1);
    if (touching != before) {
      for (unsigned m = touching & ~before; m; m &= m - 1) {
        const std::size_t p = k + static_cast<std::size_t>(__builtin_ctz(m));
        begin<kind>(s, p);
        s.active[p] = 1;
      }
      for (unsigned m = before & ~touching; m; m &= m - 1) {
        const std::size_t p = k + static_cast<std::size_t>(__builtin_ctz(m));
        if constexpr (attracts) s.part(s.context, p);
        parted += part(s, p);
        s.active[p] = 0;
      }
    }
    if (touching == 0 && !s.touch) continue;
    const Real one(1.0), zero(0.0), half(0.5);
    if constexpr (kind == Kind::spheres) {
      const Real distance = root(gap);
      const Mask coincide = less(distance, Real(1e-150));
      Real inverse = one / distance;
      if (bits(coincide)) {  // centres that coincide have no direction
        d = {select(coincide, one, d.x), select(coincide, zero, d.y), select(coincide, zero, d.z)};
        inverse = select(coincide, one, inverse);
      }
      d = inverse * d, gap = ra + rb - distance;
    }
    // A pair can touch by less than the round-off of its distance: never let its overlap be 0 or less.
    Real overlap = gap;
    if constexpr (!attracts) overlap = select(mask_of(touching), larger(gap, Real(1e-30)), gap);
    store(d.x, c.nx + o);
    store(d.y, c.ny + o);
    store(d.z, c.nz + o);
    store(overlap, c.overlap + o);
    store(less_fused(ra, half, overlap), c.la + o);
    if constexpr (kind == Kind::spheres) store(less_fused(rb, half, overlap), c.lb + o);
    c.first[kept] = k;
    c.touching[kept] = touching;
    c.count[kept] = count;
    ++kept;
  }
  return kept;
}

}  // namespace

namespace GRUS_LANES {
PassEnergy sphere_pairs(const ContactRows& s, std::size_t first, std::size_t last) {
  return choose<Kind::spheres>(s, first, last);
}
PassEnergy sphere_walls(const ContactRows& s, std::size_t first, std::size_t last) {
  return choose<Kind::walls>(s, first, last);
}
}  // namespace GRUS_LANES

}  // namespace grus::dem
