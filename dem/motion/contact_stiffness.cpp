// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/motion/contact_stiffness.hpp"

#include <algorithm>

#include "dem/contact/hull_pairs.hpp"
#include "dem/state/images.hpp"
#include "dem/state/shape_kinds.hpp"

namespace grus::dem {
namespace {

/// Hulls that do not touch and may meet within `ahead` (s), or all but lie on each other as pieces just born: faces
/// resist with their whole area from one step to the next. Their overlap once they are pressed by a ten-thousandth of
/// their size.
Overlap overlap_soon(const Grains& g, const Cell& cell, const Pair& p, const Vec3& normal, double ahead) {
  const Motion &a = g.motion[p.a], &b = g.motion[p.b];
  const double press = 1e-4 * std::min(g.extent[p.a].equivalent_radius, g.extent[p.b].equivalent_radius);
  const Vec3 drag = at_image(cell.rate, p.image);
  const double speed = (b.velocity + drag - a.velocity).norm() + a.spin.norm() * a.radius + b.spin.norm() * b.radius;
  return overlap_if_pressed(g, cell, p, normal, speed * ahead, press);
}

/// Their overlap, as the step before has left it with the pair.
Overlap overlap_as_known(const Grains& g, const Cell& cell, const Contacts& contacts, std::size_t c) {
  const Pair& p = contacts.pair[c];
  const std::size_t at = c - contacts.begin[hull_hull];
  HullGuesses::Row known{};
  if (at < contacts.guesses.row.size()) known = contacts.guesses.row[at];
  if (known.a != g.hull[p.a] || known.b != g.hull[p.b]) known.guess.octets = 0;
  return overlap_of_pair(g, cell, p, contacts.touch[c].normal, &known.guess);
}

Stiffness stiffness_of_area(const PairLaw& p, double normal) {
  return {.normal = normal, .tangential = p.friction[slide_spring] > 0 ? p.shear_ratio * normal : 0};
}

/// Hulls: the whole area resists; where it lies is looked up again.
void place_hulls(std::span<const PairLaw> pairs, const Grains& g, const Boundary& boundary, const Contacts& contacts,
                 double ahead, Team& team, Stiffnesses& all) {
  if (g.hull.empty()) return;
  std::vector<Stiffness>& k = all.of;
  all.arm.resize(k.size()), all.firm.resize(k.size(), 0);
  if (std::any_of(pairs.begin(), pairs.end(), [](const PairLaw& p) { return p.dashpot > 0; }))
    all.viscous.resize(k.size());
  const auto place = [&](std::size_t c, bool walled) {
    if (k[c].normal == 0 && walled) return;
    const Pair& p = contacts.pair[c];
    double modulus = contacts.contact.radius[c];
    Overlap o;
    if (k[c].normal == 0) {
      o = overlap_soon(g, boundary.cell, p, contacts.touch[c].normal, ahead);
      if (!(o.volume > 0)) return;
      modulus = foundation_of(pairs[p.law], g, p.a, p.b);
      k[c] = stiffness_of_area(pairs[p.law], modulus * o.area.norm());
    }
    if (!walled) {
      if (!(o.volume > 0)) o = overlap_as_known(g, boundary.cell, contacts, c);
      all.arm[c] = {o.middle, o.middle - branch(g, boundary.cell, {p.a, p.b, p.image})};
    } else {
      o = overlap_at_wall(g, boundary.walls[p.b], p.a);
      all.arm[c][0] = o.middle;
    }
    if (!(o.volume > 0)) return;
    const Vec3& n = contacts.touch[c].normal;
    if (!all.viscous.empty()) {
      const double yields = mobility(g, p.a, all.arm[c][0], n) + (walled ? 0 : mobility(g, p.b, all.arm[c][1], n));
      all.viscous[c] = pairs[p.law].dashpot * std::sqrt(k[c].normal / yields);
    }
    const double more = sharpness(o.volume, o.force.norm());
    k[c].normal *= more, k[c].tangential *= more;
    k[c].couple[roll_spring] = more * modulus * o.polar;
    all.firm[c] = more * modulus;
  };
  for (const Bin bin : {hull_hull, hull_wall}) {
    const std::size_t first = contacts.begin[bin];
    team.blocks(contacts.begin[bin + 1] - first, [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = first + begin; c < first + end; ++c) place(c, bin == hull_wall);
    });
  }
}

template <class Law>
Stiffness stiffness_of(const Law& law, const PairLaw& p, const Contact& c, double overlap) {
  if (c.stiffness <= 0) return {};
  Stiffness s = stiffness_of_area(p, law(c, overlap).grip);
  for (const SpringRow row : couple_springs)
    s.couple[row] = p.friction[row] > 0 ? s.tangential * c.radius * c.radius : 0;
  return s;
}

/// Bodies of radii H_A, H_B roll on each other by the parallel sum of both; its trace is at most that of the traces.
double rolling_path(const Grains& g, const Contacts& contacts, std::size_t k) {
  const Pair& p = contacts.pair[k];
  const Vec3& n = contacts.touch[k].normal;
  const double a = sum_of_radii(g, p.a, n);
  if (k >= contacts.begin[first_wall]) return a;
  const double b = sum_of_radii(g, p.b, -n);
  return a * b / (a + b);
}

/// Dashpots of poly-ellipsoids, as the kernels take them: by the whole mass of both, wherever the normal passes. Those
/// of spheres are left out: no normal passes by their centres, and then the step that their stiffness allows is enough.
void place_dashpots(std::span<const PairLaw> pairs, const Grains& g, const Contacts& contacts, Stiffnesses& all) {
  for (const Bin bin : {general, polyellipsoid_wall})
    for (std::size_t c = contacts.begin[bin]; c < contacts.begin[bin + 1]; ++c) {
      const Pair& p = contacts.pair[c];
      const double dashpot = pairs[p.law].dashpot;
      if (!(dashpot > 0 && all.of[c].normal > 0)) continue;
      all.viscous.resize(contacts.size());
      const double yields = g.motion[p.a].inverse_mass + (bin == general ? g.motion[p.b].inverse_mass : 0);
      all.viscous[c] = dashpot * std::sqrt(all.of[c].normal / yields);
    }
}

}  // namespace

Stiffnesses stiffnesses(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& g,
                        const Boundary& boundary, const Contacts& contacts, double ahead, Team& team) {
  Stiffnesses all;
  std::vector<Stiffness>& k = all.of;
  k.resize(contacts.size());
  const auto fill = [&](const auto& l) {
    for (std::size_t c = 0; c < contacts.size(); ++c)
      k[c] = stiffness_of(l, pairs[contacts.pair[c].law], contacts.contact[c], contacts.touch[c].overlap);
    for (std::size_t bin = 0; bin < bin_count; ++bin)
      if (pair_kind(bin).rolls)
        for (std::size_t c = contacts.begin[bin]; c < contacts.begin[bin + 1]; ++c)
          if (k[c].normal > 0)
            k[c].couple[roll_spring] +=
                l(contacts.contact[c], contacts.touch[c].overlap).force * rolling_path(g, contacts, c);
  };
  std::visit(fill, law);
  place_hulls(pairs, g, boundary, contacts, ahead, team, all);
  place_dashpots(pairs, g, contacts, all);
  return all;
}

}  // namespace grus::dem
