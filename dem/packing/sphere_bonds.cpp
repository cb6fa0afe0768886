// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/sphere_bonds.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/base/random.hpp"
#include "dem/bond/dashpots.hpp"
#include "dem/contact/broad_phase.hpp"
#include "dem/packing/bond_strength.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {
namespace {

const BondModel* rods_of(const Model& model, std::uint8_t material) {
  const auto& bond = model.materials[material].bond;
  return bond && bond->criterion == FaceCriterion::rod ? &*bond : nullptr;
}

/// A rod between two spheres, in the middle of the gap between them.
FaceBond rod_between(const Grains& g, const Cell& cell, const Candidate& pair, double ratio) {
  const Motion &a = g.motion[pair.a], &b = g.motion[pair.b];
  const Quat &qa = g.orientation[pair.a], &qb = g.orientation[pair.b];
  const Vec3 shift = at_image(cell.vectors, pair.image);
  const Vec3 apart = b.position + shift - a.position, n = apart.normalized();
  const Vec3 middle = a.position + 0.5 * (apart.norm() + a.radius - b.radius) * n;
  const double radius = ratio * std::min(a.radius, b.radius);
  FaceBond s;
  s.ends = {pair.a, pair.b, pair.image};
  s.at_a = qa.conjugate() * (middle - a.position), s.at_b = qb.conjugate() * (middle - shift - b.position);
  s.normal = qa.conjugate() * n, s.e1 = qa.conjugate() * across(n)[0];
  s.rest = qb.conjugate() * qa;
  s.area = pi * radius * radius;
  s.i1 = s.i2 = 0.25 * s.area * radius * radius;
  return s;
}

}  // namespace

bool bonds_spheres(const Model& model) {
  for (std::size_t m = 0; m < model.materials.size(); ++m)
    if (rods_of(model, static_cast<std::uint8_t>(m))) return true;
  return false;
}

BondedFaces bond_spheres(const Model& model, std::span<const Index> body, State& state, Team& team) {
  const Grains& g = state.grains;
  double reach = 0, largest = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    largest = std::max(largest, g.motion[i].radius);
    if (const BondModel* of = rods_of(model, g.material[i])) reach = std::max(reach, of->gap);
  }
  Candidates near;
  SearchRoom room;
  find_candidates(g, state.boundary.cell, reach * largest, near, room, team);
  auto& rows = state.bonds.face.row;
  const std::size_t first = rows.size();
  for (const Candidate& pair : near.pair) {
    const BondModel *of_a = rods_of(model, g.material[pair.a]), *of_b = rods_of(model, g.material[pair.b]);
    if (!of_a || !of_b || !is_sphere(g, pair.a) || !is_sphere(g, pair.b)) continue;
    if (!body.empty() && body[g.id[pair.a]] != body[g.id[pair.b]]) continue;
    const BondModel& weaker = weaker_of(*of_a, *of_b);
    const double small = std::min(g.motion[pair.a].radius, g.motion[pair.b].radius);
    FaceBond s = rod_between(g, state.boundary.cell, pair, weaker.radius_ratio);
    const double depth_a = s.at_a.norm(), depth_b = s.at_b.norm();
    if (depth_a + depth_b > g.motion[pair.a].radius + g.motion[pair.b].radius + weaker.gap * small) continue;
    if (of_a == of_b)
      set_stiffness(weaker, depth_a + depth_b, s);
    else
      set_stiffness(*of_a, depth_a, *of_b, depth_b, s);
    bool coarse = false;
    give_strength(weaker, 1, model.seed, rows.size(), depth_a + depth_b, s, coarse);
    rows.push_back(s);
    if (weaker.damping == 0) continue;
    state.bonds.dashpot.resize(rows.size());
    state.bonds.dashpot.back() = dashpot_of(s, g, weaker.damping);
  }
  if (!state.bonds.dashpot.empty()) state.bonds.dashpot.resize(rows.size());
  BondedFaces count;
  count.bonds = rows.size() - first;
  return count;
}

std::vector<Sphere> spheres_in_spheres(std::span<const Sphere> parents, const RadiusDistribution& radius,
                                       double solid_fraction, std::uint64_t seed, Team& team, const Watch& watch,
                                       std::vector<Index>& body) {
  constexpr double spheres_a_side = 10;  // at least, so that hardly two grains are filled alike
  double largest = 0;
  for (const Sphere& parent : parents) largest = std::max(largest, parent.radius);
  const double side = std::max(2 * largest, spheres_a_side * 2 * radius.mean);
  const Packing packing =
      random_packing(Vec3::Constant(side), radius, solid_fraction, 0, Container::periodic, seed, team, watch);
  std::vector<Sphere> all;
  for (std::size_t k = 0; k < parents.size(); ++k) {
    const Sphere& parent = parents[k];
    const std::uint64_t draw = seed + 1000003 * (k + 1);
    const Quat turn = random_rotation(draw, 0);
    Vec3 about;
    for (int c = 0; c < 3; ++c)
      about[c] = side * random_uniform(draw, 0, Purpose::position, static_cast<std::uint64_t>(c));
    const std::size_t before = all.size();
    for (const Sphere& s : packing.spheres) {
      Vec3 from = s.position - about;  // to the nearest image: a parent is no wider than the packing
      for (int c = 0; c < 3; ++c) from[c] -= side * std::round(from[c] / side);
      if (from.norm() + s.radius > parent.radius) continue;
      all.push_back({parent.position + turn * from, s.radius});
      body.push_back(static_cast<Index>(k));
    }
    if (all.size() == before)
      throw InputError(
          fmt::format("a grain of radius {:.3g} m holds no sphere of a mean radius of {:.3g} m: smaller "
                      "spheres are needed",
                      parent.radius, radius.mean));
  }
  return all;
}

}  // namespace grus::dem
