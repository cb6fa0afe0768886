// SPDX-License-Identifier: LGPL-3.0-or-later
// Grains on lattices for the tests.
#pragma once

#include "dem/fracture/crack_run.hpp"
#include "dem/fracture/lattice_crack.hpp"
#include "tests/hulls.hpp"

namespace grus::dem::test {

inline constexpr double youngs = 100e9, poisson = 0.15;  // of Zhu and Zhao's sand

inline LatticeChoice lattice_of(int points, double horizon = 2.5, bool partial = true, bool turned = true) {
  return {.points = points, .horizon = horizon, .partial_volume = partial, .turned = turned};
}

/// Values of a field by point, x in diameters along the axes of the lattice.
template <class F>
PointColumns field(const PointLattice& lattice, double diameter, F&& of) {
  PointColumns u(lattice.size());
  for (std::size_t i = 0; i < lattice.size(); ++i) {
    const Vec3 v = of(Vec3(lattice.axes.transpose() * lattice.point[i] / diameter));
    for (std::size_t axis = 0; axis < 3; ++axis) u(i, axis) = v[static_cast<Eigen::Index>(axis)];
  }
  return u;
}

inline PointColumns random_field(const PointLattice& lattice, std::uint64_t id) {
  std::uint64_t k = 0;
  return field(lattice, 1, [&](const Vec3&) { return random_vector(id, k++); });
}

/// A unit force between two platens along z.
inline std::vector<PatchLoad> pressed(double diameter, double force = 1) {
  return {{Vec3(0, 0, 0.5 * diameter), Vec3(0, 0, -force)}, {Vec3(0, 0, -0.5 * diameter), Vec3(0, 0, force)}};
}

inline PointColumns times(double factor, PointColumns c) {
  for (std::size_t k = 0; k < c.size(); ++k) c[k] *= factor;
  return c;
}

/// A sphere of diameter 1 between platens, its answer to a unit force.
struct Platens {
  PointLattice lattice;
  PeridynamicSolid solid;
  PointColumns load, answer;

  Platens(const LatticeChoice& choice, std::uint64_t id)
      : lattice(make_lattice(lattice_sphere(0.5), choice, 7, id)),
        solid(lattice, poisson),
        load(columns_of(point_forces(lattice, pressed(1), LatticeChoice{}.patch, 1))),
        answer(lattice.size()) {
    long sweeps = 0;
    REQUIRE(solve(solid, load, answer, 1e-5, 500, sweeps) > 0);
  }

  /// Whether it holds a force (E d^2 s_c), asked for as long as it takes.
  HoldTest hold(double force) {
    solid.mend();
    PointColumns u = times(force, answer);
    return hold_test(solid, times(force, load), u, {.rounds = 2000, .work = 1e9});
  }
  /// The least force that it does not hold, in steps of 4 %.
  double strength() {
    double force = 0.5;
    while (!hold(force).holds()) force /= 1.04;
    while (hold(force).holds()) force *= 1.04;
    return force;
  }
};

}  // namespace grus::dem::test
