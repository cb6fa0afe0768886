// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/gauge.hpp"

#include "dem/rve/wall_force.hpp"

namespace grus::dem {
namespace {

/// How dead loads pull: along their sum, or along the first of them where they hold each other.
struct DeadPull {
  Vec3 along = Vec3::Zero();
  bool balanced = false;

  explicit DeadPull(const Bonds& bonds) {
    double all = 0;
    for (const DeadLoad& load : bonds.load) along += load.force, all += load.force.norm();
    balanced = along.norm() < 1e-6 * all;
    along = (balanced ? bonds.load.front().force : along).normalized();
  }
  /// Its part in the force of all: of loads that hold each other each half counts once.
  double part(const DeadLoad& load, const Vec3& force) const {
    const double f = force.dot(along);
    return !balanced ? f : load.force.dot(along) < 0 ? -0.5 * f : 0.5 * f;
  }
  double of(const Bonds& bonds, Vec3 DeadLoad::*force) const {
    double sum = 0;
    for (const DeadLoad& load : bonds.load) sum += part(load, load.*force);
    return sum;
  }
};

double gap_of_platens(const State& s, int axis) {
  return (s.boundary.walls[1].point - s.boundary.walls[0].point)[axis];
}

}  // namespace

bool box_of_walls(const State& s) { return !s.boundary.cell.everywhere() && bulk_volume(s.boundary) > 0; }

const Mat3& sample_stress(const State& s, const Measurement& m) { return box_of_walls(s) ? m.wall_stress : m.stress; }

bool has_faces(const Programme& test, const State& s) {
  return (box_of_walls(s) && (!s.boundary.cell.walled || test.axis == 2)) || test.kind == TestKind::platens;
}

std::array<double, 2> face_stresses(const Programme& test, const State& first, const State& s) {
  const int axis = test.axis;
  double area = 0;
  if (test.kind == TestKind::platens) area = std::pow(gap_of_platens(first, axis), 2);
  std::array<std::size_t, 2> face{};
  for (std::size_t w = 0; w < s.boundary.walls.size(); ++w)
    for (std::size_t side = 0; side < 2; ++side)
      if (s.boundary.walls[w].facing()[axis] == (side ? -1 : 1)) face[side] = w;
  if (area == 0)
    area = bulk_volume(s.boundary) / (s.boundary.walls[face[1]].point - s.boundary.walls[face[0]].point)[axis];
  return {-wall_force(s, face[0])[axis] / area, wall_force(s, face[1])[axis] / area};
}

double axial_stress(const Programme& test, const State& first, const State& s, const Measurement& m) {
  if (!has_faces(test, s)) return -m.stress(test.axis, test.axis);
  const auto [back, front] = face_stresses(test, first, s);
  return 0.5 * (back + front);
}

double axial_stress(const Programme& test, const State& first, const State& s) {
  Measurement m;
  if (!has_faces(test, s)) m.stress = love_weber(s, bulk_volume(s.boundary));
  return axial_stress(test, first, s, m);
}

double axial_strain(const Programme& test, const State& first, const State& s, const Mat3& initial_cell) {
  const int axis = test.axis;
  if (test.kind != TestKind::platens) return -displacement_gradient(s, test.loading, initial_cell)(axis, axis);
  return 1 - gap_of_platens(s, axis) / gap_of_platens(first, axis);
}

bool tells_q(const Programme& test) {
  return test.kind == TestKind::constant_p || test.kind == TestKind::true_triaxial;
}

bool tells_stress(const Programme& test) { return test.gauge || tells_q(test); }

double test_stress(const Programme& test, const State& s, const Measurement& m) {
  if (test.gauge) return load_of(*test.gauge, s) * test.gauge->stress_per_load;
  return tells_q(test) ? std::sqrt(1.5) * deviator(sample_stress(s, m)) : 0;
}

bool has_stress(const Programme& test, const State& s) {
  return tells_stress(test) || has_faces(test, s) || bulk_volume(s.boundary) > 0;
}

double load_of(const Gauge& gauge, const State& s) {
  double load = 0;
  for (const auto& [wall, weight] : gauge.walls) load += weight * wall_force(s, wall).dot(gauge.along);
  return load;
}

double way_of(const Gauge& gauge, const State& first, const State& s) {
  return Vec3(s.boundary.walls[gauge.moving].point - first.boundary.walls[gauge.moving].point).dot(gauge.along);
}

bool dead_loaded(const Programme& test, const State& first) { return !test.gauge && !first.bonds.load.empty(); }

std::optional<double> dead_load(const Programme& test, const State& s) {
  if (!dead_loaded(test, s)) return {};
  return DeadPull(s.bonds).of(s.bonds, &DeadLoad::felt);
}

double dead_way(const State& first, const State& s) {
  const DeadPull pull(s.bonds);
  const double whole = pull.of(s.bonds, &DeadLoad::force);
  double way = 0;
  for (std::size_t k = 0; k < s.bonds.load.size(); ++k) {
    const DeadLoad& load = s.bonds.load[k];
    way += load.force.dot(pull.along) / whole * (load.point - first.bonds.load[k].point).dot(pull.along);
  }
  return way;
}

Landing stress_landing(const Programme& test, const State& first) {
  const double asked = *test.final_stress;
  return {.left = [&, asked](const State& s) { return asked - axial_stress(test, first, s); },
          .near = 0.2 * asked,
          .axis = test.axis};
}

double lode_angle(const Mat3& stress) {
  const Vec3 s = -Eigen::SelfAdjointEigenSolver<Mat3>(stress, Eigen::EigenvaluesOnly).eigenvalues();  // falling
  return std::atan2(std::sqrt(3.0) * (s[1] - s[2]), 2 * s[0] - s[1] - s[2]);
}

double deviator(const Mat3& m) { return (m - m.trace() / 3 * Mat3::Identity()).norm(); }

}  // namespace grus::dem
