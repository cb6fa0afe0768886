// SPDX-License-Identifier: LGPL-3.0-or-later
// Stages for the tests, and a cell whose stresses are set.
#pragma once

#include "dem/sample/stages.hpp"
#include "tests/helpers.hpp"

namespace grus::dem::test {

inline constexpr double R = 1e-3, strain = 0.01;

/// Eight spheres in a cell, each pressed to its next ones along the axes.
inline State lattice(const Model& model, double pressed = strain) {
  State s;
  const double apart = 2 * R * (1 - pressed);
  for (int i = 0; i < 8; ++i) add(s, PolyEllipsoid::sphere(R), apart * Vec3(i % 2, i / 2 % 2, i / 4), 2650);
  s.boundary.cell.vectors = 2 * apart * Mat3::Identity();
  Team team(1);
  prepare(model, s, team);
  return s;
}

/// Gives its contacts forces that carry these stresses (Pa, compression-positive) along its axes: of eight contacts
/// along each of them.
inline State& press(State& s, const Vec3& stress) {
  const double volume = s.boundary.cell.volume();
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    Touch& t = s.contacts.touch[k];
    for (int a = 0; a < 3; ++a)
      if (s.contacts.contact.touching(k) && std::abs(t.normal[a]) > 0.9)
        t.force = stress[a] * volume / (4 * s.boundary.cell.vectors(a, a)) * t.normal;
  }
  return s;
}

inline Model grains(double friction = 0.5) { return model_of(solid(10e9, 0.2, 2650, friction)); }

inline Stage stage(StageKind kind, double rate = 0.5) {
  Stage s;
  s.name = "one", s.kind = kind, s.strain_rate = rate, s.rows = 10, s.max_strain = 0.6;
  return s;
}

inline StageEnds ends_by(std::optional<double> StageEnds::*what, double value) {
  StageEnds ends;
  ends.*what = value;
  return ends;
}

inline Programme test_of(std::vector<Stage> stages, const Vec3& size = Vec3::Constant(4 * R)) {
  Programme test;
  test.kind = TestKind::staged, test.stages = std::move(stages), test.loading.initial_size = size;
  return test;
}

inline constexpr double inf = std::numeric_limits<double>::infinity();

}  // namespace grus::dem::test
