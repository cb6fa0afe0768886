// SPDX-License-Identifier: LGPL-3.0-or-later
// One body under forces on points of it, as tests of cleavage look at it.
#pragma once

#include "dem/fracture/hull_loads.hpp"
#include "tests/hulls.hpp"

namespace grus::dem::test {

using PointLoads = std::vector<std::pair<Vec3, Vec3>>;  // points of a body (m), forces on them (N)

/// One body, its mass centre at the origin, after a step so short that nothing moves.
inline State loaded_body(const Model& model, const Polyhedron& body, const PointLoads& loads) {
  State s;
  add_body(s, body, Vec3::Zero(), Quat::Identity());
  for (const auto& [at, force] : loads) {
    DeadLoad load{0, s.grains.orientation[0].conjugate() * at, force};
    load.point = at;
    s.bonds.load.push_back(load);
  }
  Team team(1);
  prepare(model, s, team);
  s.dt = 1e-12;
  run_steps(model, s, 1, team);
  index_bonds(s.grains.size(), s.bonds, s.break_room.bonds);
  return s;
}

/// Grain i with all that loads it.
inline LoadedHull loaded_hull(const Model& model, const State& s, std::size_t i) {
  return {model.law, 0.2, s.grains, s.boundary, s.contacts, s.bonds, s.break_room.bonds, i};
}

}  // namespace grus::dem::test
