// SPDX-License-Identifier: LGPL-3.0-or-later
// Walls that seek a stress by themselves, and true triaxial paths: forces, ways and work in closed form, the orders of
// the axes, Lode's angle; same bits for any threads.
#include "dem/packing/packing.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/press.hpp"
#include "dem/rve/servo.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/sample/gauge.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double stiffness = 1e5;  // N/m, of a contact with a rigid wall

/// A sphere of 1 mm on a floor under a lid that is 0.05 mm above it.
State under_a_lid(const Model& model, Team& team, const Vec3& way_of_lid = Vec3::Zero()) {
  State s;
  add(s, PolyEllipsoid::sphere(1e-3), Vec3(0, 0, 1e-3), 2650);
  add_floor(s);
  s.boundary.walls.push_back(
      {.point = Vec3(0, 0, 2.05e-3), .shape = PlaneWall{-Vec3::UnitZ()}, .velocity = way_of_lid, .material = 1});
  prepare(model, s, team);
  return s;
}

Model springs(double friction) {
  Model model = linear_model(stiffness, 1, 2650, friction);
  model.materials[0].restitution = 0.5;
  set_damping(model, 0.2);
  make_pair_laws(model);
  return model;
}

State box_of_spheres(const Model& model, Team& team) {
  State s;
  const Packing p = random_packing(Vec3::Constant(8e-3), {"uniform", 1e-3, 0, 0.8e-3, 1.2e-3}, 0.53, 0, false, 1);
  for (const auto& sphere : p.spheres) add(s, PolyEllipsoid::sphere(sphere.radius), sphere.position, 2650);
  add_box(s, 8e-3);
  prepare(model, s, team);
  return s;
}

Mat3 diagonal(double x, double y, double z) { return Vec3(x, y, z).asDiagonal(); }

}  // namespace

TEST_CASE("a lid comes down until it presses with its stress on its area: force, way and energy in closed form") {
  const Model model = springs(0);
  Team team(1);
  State s = under_a_lid(model, team);
  Loading loading;
  loading.walls = {{.wall = 1, .stress = 2e5, .area = 4e-6}};
  begin_loading(model, s, loading);
  load(model, s, loading, 5e-3, team);
  const double force = 2e5 * 4e-6, one = force / stiffness;
  const WallForce found = force_of(s, loading.walls[0]);
  CHECK(found.asked == Approx(force).epsilon(1e-12));
  CHECK(found.force == Approx(force).epsilon(1e-3));
  CHECK(stress_error(s, loading, measure(model, s)) < 1e-3);
  CHECK(s.boundary.walls[1].point.z() == Approx(2e-3 - 2 * one).epsilon(1e-6));
  CHECK(measure(model, s).elastic == Approx(2 * 0.5 * force * one).epsilon(2e-3));
  CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 1e-3);
  CHECK(s.ledger.work > 0.99 * force * one);  // more: the lid arrives with a speed
}

TEST_CASE("the stress of a wall goes on at its rate, and ends at none") {
  const Model model = springs(0);
  Team team(1);
  State s = under_a_lid(model, team);
  Loading loading;
  loading.walls = {{.wall = 1, .stress = 1e5, .stress_rate = 1e7, .area = 4e-6}};
  begin_loading(model, s, loading);
  for (const double time : {5e-3, 10e-3}) {
    load(model, s, loading, time, team);
    CHECK(force_of(s, loading.walls[0]).force == Approx((1e5 + 1e7 * time) * 4e-6).epsilon(1e-3));
  }
  loading.walls[0].stress_rate = -2e7;
  CHECK(force_of(s, loading.walls[0]).asked == 0);
  load(model, s, loading, 15e-3, team);
  CHECK(std::abs(force_of(s, loading.walls[0]).force) < 1e-9);
  CHECK(stress_error(s, loading, measure(model, s)) != stress_error(s, loading, measure(model, s)));  // nothing asked
}

TEST_CASE("a wall that presses goes along its plane as it is told, and no faster across than it may") {
  const Model model = springs(0);
  Team team(1);
  State s = under_a_lid(model, team, Vec3(0.03, 0, 0));
  Loading loading;
  loading.walls = {{.wall = 1, .stress = 2e5, .area = 4e-6, .max_speed = 0.02}};
  begin_loading(model, s, loading);
  load(model, s, loading, 1e-3, team);
  CHECK(s.boundary.walls[1].point.x() == Approx(3e-5).epsilon(1e-9));
  const double fallen = 2.05e-3 - s.boundary.walls[1].point.z();
  CHECK(fallen <= 2e-5 * (1 + 1e-9));
  CHECK(fallen > 1.9e-5);  // at its fastest after twenty steps
}

TEST_CASE("sides of a box press each with its own stress on their section as it is, and their work is counted") {
  Model model = model_of(solid(10e9, 0.2, 2650, 0.5, 0.5));
  set_damping(model, 0.2);
  Loading loading;
  loading.walls = {{.wall = 1, .stress = 2e5}, {.wall = 2, .stress = 3e5}, {.wall = 5, .stress = 5e5}};
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 3}) {
    Team team(threads);
    State s = box_of_spheres(model, team);
    Loading now = loading;
    begin_loading(model, s, now);
    load(model, s, now, 2e-3, team);
    load(model, s, now, 4e-3, team);
    const Vec3 size = size_of(s.boundary);
    const std::array<double, 3> area{size.y() * size.z(), size.x() * size.z(), size.x() * size.y()};
    for (std::size_t k = 0; k < 3; ++k) {
      const WallForce found = force_of(s, now.walls[k]);
      CHECK(found.asked == Approx(now.walls[k].stress * area[k]).epsilon(1e-12));
      CHECK(found.force == Approx(found.asked).epsilon(1e-3));
    }
    CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 5e-3);
    CHECK(s.ledger.work > 0);
    hashes.push_back(hash(s));
  }
  CHECK(hashes[0] == hashes[1]);
}

TEST_CASE("a true triaxial test brings each axis to its stress in proportion to time; then the middle one follows") {
  Loading l;
  l.first = Vec3(-1e5, -2e5, -3e5), l.consolidation = 10, l.ratio = 0.25, l.middle = 0;
  for (std::size_t k = 0; k < 3; ++k)
    l.axes[k] = {.strain_rate = 0, .stress = (*l.first)[static_cast<int>(k)], .max_rate = 7};
  l.axes[2] = {.strain_rate = -0.5, .stress = {}, .max_rate = 9};
  const Vec3 stress(-1.1e5, -2e5, -6e5);
  for (const auto& [time, part] : {std::pair{2.0, 0.25}, {8.0, 1.0}, {9.9, 1.0}}) {
    const auto axes = controls(l, stress, time);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(*axes[k].stress == Approx(part * (*l.first)[static_cast<int>(k)]));
      CHECK(axes[k].strain_rate == 0);
    }
  }
  auto later = controls(l, stress, 10);
  CHECK((!later[2].stress && later[2].strain_rate == -0.5 && later[0].max_rate == 7));
  CHECK(*later[1].stress == -2e5);
  CHECK(*later[0].stress == Approx(-2e5 + 0.25 * (-6e5 + 2e5)));
  l.mean = -2e5;  // and their mean stays
  later = controls(l, stress, 10);
  CHECK(*later[0].stress + *later[1].stress - 6e5 == Approx(-6e5));
  CHECK(*later[0].stress - *later[1].stress == Approx(0.25 * (-6e5 - *later[1].stress)));
  CHECK(*controls(l, stress, 9)[0].stress == -1e5);  // it is brought to its own first stress all the same
  l.ratio = 0, l.first = {};
  const double alike = *controls(l, stress, 10)[0].stress;
  l.ratio = {};
  CHECK(*controls(l, stress, 10)[0].stress == alike);  // b = 0: the two lesser ones are one
}

TEST_CASE("three stresses are met in a box and in a cell, and an axis that is told to stand stands") {
  Model model = model_of(solid(10e9, 0.2, 2650, 0.5, 0.5));
  set_damping(model, 0.2);
  Team team(1);
  for (const bool periodic : {false, true}) {
    INFO(periodic);
    State s;
    if (periodic) {
      const Packing p = random_packing(Vec3::Constant(8e-3), {"uniform", 1e-3, 0, 0.8e-3, 1.2e-3}, 0.55, 0, true, 1);
      for (const auto& sphere : p.spheres) add(s, PolyEllipsoid::sphere(sphere.radius), sphere.position, 2650);
      s.boundary.cell.vectors = 8e-3 * Mat3::Identity();
      prepare(model, s, team);
    } else {
      s = box_of_spheres(model, team);
    }
    Loading l;
    l.driven = l.holds = true, l.first = Vec3(-2e5, -3e5, -4e5), l.consolidation = 5e-3;
    l.axes = {AxisControl{0, -2e5, 6}, AxisControl{0, {}, 6}, AxisControl{.strain_rate = -1, .stress = {}}};
    begin_loading(model, s, l);
    load(model, s, l, 5e-3, team);
    const Vec3 first = normal_stresses(s), size = size_of(s.boundary);
    // A cell that has just jammed is corrected every few steps, walls in each.
    for (int k = 0; k < 3; ++k) CHECK(first[k] == Approx((*l.first)[k]).epsilon(periodic ? 1e-2 : 1e-3));
    constexpr int looks = 50;
    double off = 0;  // one look may meet a cell of seventy grains as it collapses
    for (int k = 1; k <= looks; ++k) {
      load(model, s, l, 5e-3 + 10e-3 * k / looks, team);
      off += std::abs(normal_stresses(s)[0] / -2e5 - 1) / looks;
    }
    CHECK(off < (periodic ? 2e-2 : 1e-3));
    CHECK(size_of(s.boundary)[1] == Approx(size[1]).epsilon(1e-12));
    CHECK(size_of(s.boundary)[2] == Approx(size[2] - 1e-2 * l.initial_size[2]).epsilon(1e-9));
    CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 5e-3);
  }
}

TEST_CASE("Lode's angle is 0 in triaxial compression, 60 degrees in extension, and follows b, however axes lie") {
  CHECK(std::abs(lode_angle(diagonal(-1, -1, -5))) < 1e-12);
  CHECK(lode_angle(diagonal(-5, -1, -5)) == Approx(pi / 3));
  CHECK(lode_angle(diagonal(-3, -5, -1)) == Approx(pi / 6));
  const Mat3 r = rotation_by(Vec3(0.3, -1, 2)).toRotationMatrix();
  for (const double b : {0.1, 0.4, 0.9}) {
    const Mat3 stress = r * diagonal(-1e5, -1e5 - b * 3e5, -4e5) * r.transpose();
    CHECK(std::tan(lode_angle(stress)) == Approx(std::sqrt(3.0) * b / (2 - b)).epsilon(1e-9));
  }
}
