// SPDX-License-Identifier: LGPL-3.0-or-later
// Loose hulls that press each other, and what holds them, for tests of steps and inertia.
#pragma once

#include "dem/motion/grain_stiffness.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "tests/hulls.hpp"

namespace grus::dem::test {

inline HeldGrains held_of(const Model& model, const State& s) {
  return {model.law, model.pairs, model.materials.size(), s.grains, s.boundary, s.contacts, s.bonds};
}

/// Cells of a Voronoi mesh that has been pressed together in a periodic cell by a part, each on its own.
inline State pressed_cells(const Model& model, std::size_t count, double strain, std::uint64_t seed = 1) {
  Team team(1);
  const double size = std::cbrt(static_cast<double>(count));
  State s;
  s.boundary.cell.vectors = size * Mat3::Identity();
  Tessellation cells = voronoi_packing(periodic_space(Vec3::Constant(size)), count, 1, seed, team);
  add_voronoi_grains(model, cells, 0, s);
  s.boundary.cell.vectors *= 1 - strain;
  for (Motion& m : s.grains.motion) m.position *= 1 - strain;
  return s;
}

inline Model loose(double friction) {
  Model model = hull_model(friction);
  model.numerics.max_energy_error = INFINITY;
  return model;
}

}  // namespace grus::dem::test
