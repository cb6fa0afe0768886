// SPDX-License-Identifier: LGPL-3.0-or-later
// Balls that break by peridynamics, pressed against one another in a cell.
#pragma once

#include "dem/fracture/platens.hpp"
#include "dem/io/archive.hpp"
#include "dem/packing/random_hulls.hpp"
#include "dem/rve/crack_tests.hpp"
#include "tests/bonded.hpp"
#include "tests/hulls.hpp"

namespace grus::dem::test {

/// Rock whose balls break at `strength` (Pa, force over square of diameter) between platens.
inline Model cracking_rock(double strength, int points = 500) {
  Model model = hull_model(0.5);
  FractureModel f;
  CrackTests c;
  c.lattice.lattice.points = points;
  c.lattice.youngs_modulus = 60e9, c.lattice.poissons_ratio = 0.15;
  c.toughness.reference_diameter = 1;
  const double horizon = c.lattice.lattice.horizon * c.lattice.lattice.spacing();
  const double stretch = strength / (platen_number(c.lattice) * c.lattice.youngs_modulus);
  c.toughness.energy = fracture_energy(c.toughness.form, stretch, c.lattice.youngs_modulus, 0.15, horizon);
  f.criteria.emplace_back(PlatenForce{strength});
  f.splitter = Shatter{};
  f.cracks = c;
  model.materials[0].fracture = f;
  return model;
}

inline constexpr double crushing = 1e3;  // Pa

/// Balls of 32 planes, turned at random, on a cubic lattice in which each presses six others, pressed and sheared on.
inline State crushed(const Model& model, int threads, std::uint64_t steps, bool saved = false) {
  Team team(threads);
  State s;
  constexpr int side = 3;
  constexpr double apart = 1.93;  // radii of the ball's volume: its planes lie at 0.951
  s.boundary.cell.vectors = side * apart * Mat3::Identity();
  for (int n = 0; n < side * side * side; ++n) {
    const Vec3 at = apart * (Vec3(n % side, n / side % side, n / side / side) - Vec3::Ones());
    add_body(s, ball_of_planes(Vec3::Ones()).body, at, random_rotation(3, static_cast<std::uint64_t>(n)));
  }
  prepare(model, s, team);
  Mat3 rate = Mat3::Zero();
  rate(2, 2) = -2, rate(0, 1) = 1;
  set_cell_rate(s, rate);
  for (std::uint64_t done = 0; done < steps;) {
    if (saved && done > steps / 2) s = state_of(bytes_of(s)), saved = false;
    update_time_step(model, s);
    done += run_steps(model, s, std::min<std::uint64_t>(10, steps - done), team);
  }
  return s;
}

}  // namespace grus::dem::test
