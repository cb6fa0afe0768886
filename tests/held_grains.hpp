// SPDX-License-Identifier: LGPL-3.0-or-later
// Voronoi grains that press each other, and what holds them.
#pragma once

#include "dem/motion/grain_stiffness.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "tests/hulls.hpp"

namespace grus::dem::test {

inline HeldGrains held_of(const Model& model, const State& s) {
  static Team alone(1);
  return {model.law, model.pairs, model.materials.size(), s.grains, s.boundary, s.contacts, s.bonds, 0, alone};
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

/// 64 Voronoi grains that fill a periodic cube, which is pressed along z and sheared at these rates (m/s), ready to
/// run.
inline State deforming_cube(const Model& model, double pressed, double sheared, Team& team) {
  State s;
  s.boundary.cell.vectors = 4 * Mat3::Identity();
  add_voronoi_grains(model, voronoi_packing(periodic_space(Vec3::Constant(4)), 64, 3, 1, team), 0, s);
  prepare(model, s, team);
  Mat3 rate = Mat3::Zero();
  rate(2, 2) = -pressed, rate(0, 1) = sheared;
  set_cell_rate(s, rate);
  return s;
}

inline Model loose(double friction) {
  Model model = hull_model(friction);
  model.numerics.max_energy_error = INFINITY;
  return model;
}

}  // namespace grus::dem::test
