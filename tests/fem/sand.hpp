// SPDX-License-Identifier: LGPL-3.0-or-later
// A small periodic cell for the tests of what is built on it.
#pragma once

#include "dem/packing/packing.hpp"
#include "dem/rve/loading.hpp"
#include "tests/helpers.hpp"

namespace grus::fem::test {

using namespace grus::dem;
namespace test = grus::dem::test;

struct Sand {
  std::shared_ptr<const Model> model;
  QuasiStatic q;
  State state;
};

/// 60 frictional spheres, 100 kPa.
inline Sand sand(std::uint64_t seed = 4) {
  Model model = test::model_of(test::solid(600e6, 0.3, 2650, 0.5, 0.5));
  set_damping(model, 0.3);
  State s;
  const Packing p = random_packing(Vec3::Constant(0.036), {"uniform", 5e-3, 0, 4e-3, 6e-3}, 0.58, 0, true, seed);
  for (const auto& sphere : p.spheres) test::add(s, PolyEllipsoid::sphere(sphere.radius), sphere.position, 2650);
  s.boundary.cell.vectors = p.box.asDiagonal();
  Team team(1);
  prepare(model, s, team);
  QuasiStatic q;
  q.unbalanced_force = q.stress_change = 1e-3, q.pressure_floor = 5e4, q.inertial_number = 2e-3;
  compress_isotropically(model, q, s, 1e5, team);
  s.ledger = {};
  prepare(model, s, team);
  return {std::make_shared<const Model>(model), q, s};
}

inline const Sand& standard() {
  static const Sand s = sand();
  return s;
}

}  // namespace grus::fem::test
