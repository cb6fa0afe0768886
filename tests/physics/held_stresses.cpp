// SPDX-License-Identifier: LGPL-3.0-or-later
// Stresses that are held: how far off they are, and what walls that press do about a sample that drifts.
#include "dem/packing/packing.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/press.hpp"
#include "dem/rve/servo.hpp"
#include "tests/held_walls.hpp"
#include "tests/helpers.hpp"
#include "tests/staged.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

TEST_CASE("the error of a stress is that of the axis that is furthest off, and of the mean where that is asked") {
  State s;
  s.boundary.cell.vectors = Mat3::Identity();
  Measurement m;
  const Vec3 asked(-1e6, -2e6, -4e6);
  for (int worst = 0; worst < 3; ++worst) {
    Vec3 found = 1.01 * asked;
    found[worst] = 0.9 * asked[worst];
    m.stress = found.asDiagonal();
    Loading loading;
    for (int k = 0; k < 3; ++k) loading.axes[static_cast<std::size_t>(k)] = {0, asked[k], 1};
    CHECK(stress_error(s, loading, m) == Approx(0.1));
    loading.axes[static_cast<std::size_t>(worst)] = {0, {}, 1};  // driven: nothing is asked of it
    CHECK(stress_error(s, loading, m) == Approx(0.01));
  }
  m.stress = -2.2e6 * Mat3::Identity();
  Loading of_mean;
  of_mean.mean = -2e6;
  CHECK(stress_error(s, of_mean, m) == Approx(0.1));
}

TEST_CASE("a sample that drifts is held by a hundredth of what presses it, as its weight would be, and no more") {
  Model model = model_of(solid(10e9, 0.2, 2650, 0.5, 0.5));
  set_damping(model, 0.2);
  Team team(1);
  State s;
  const Packing p = random_packing(Vec3::Constant(8e-3), {"uniform", 1e-3, 0, 0.8e-3, 1.2e-3}, 0.53, 0, false, 1);
  for (const auto& sphere : p.spheres) add(s, PolyEllipsoid::sphere(sphere.radius), sphere.position, 2650);
  add_box(s, 8e-3);
  prepare(model, s, team);
  Loading loading = hold_by_walls(model, s, team);
  const auto speeds = [&](State now) {
    press_walls(model, now, loading);
    return std::array{now.boundary.walls[0].velocity.x(), now.boundary.walls[1].velocity.x()};
  };
  // Grains that no wall feels drift: not at all, and far faster than the hundredth lets be stopped.
  std::vector<bool> felt(s.grains.size());
  for (std::size_t k = s.contacts.begin[first_wall]; k < s.contacts.size(); ++k) felt[s.contacts.pair[k].a] = true;
  double inner = 0;
  for (std::size_t i = 0; i < felt.size(); ++i) inner += felt[i] ? 0 : s.grains.mass[i];
  const auto drifting = [&](double drift) {
    State now = s;
    for (std::size_t i = 0; i < felt.size(); ++i)
      if (!felt[i]) now.grains.motion[i].velocity.x() += (drift - momentum(s.grains).x()) / inner;
    return now;
  };
  const double volume = bulk_volume(s.boundary), width = size_of(s.boundary).x(), mass = total_mass(s.grains);
  const double force = 1e6 * volume / width, all_of_it = force * width / std::sqrt(1e6 * volume / mass);
  const auto still = speeds(drifting(0)), braked = speeds(drifting(0.2 * all_of_it));
  model.motion.gravity = Vec3(0.01 * force / mass, 0, 0);
  const auto weighs = speeds(drifting(0));
  for (std::size_t w = 0; w < 2; ++w) {
    CHECK(std::abs(weighs[w] - still[w]) > 1e-3);
    CHECK(std::abs(braked[w] - weighs[w]) < 1e-9 * std::abs(weighs[w] - still[w]));
  }
}

TEST_CASE("the rate of an axis is the cell's along its edges, and that of the wall that is driven beyond") {
  State s;
  const auto add = [&](const Vec3& facing, double speed) {
    Wall wall;
    wall.shape = PlaneWall{facing}, wall.velocity = -speed * facing;
    s.boundary.walls.push_back(wall);
  };
  add(-Vec3::UnitZ(), -3), add(-Vec3::UnitX(), 5);
  add(-Vec3::UnitZ(), 0.5);  // one's own, that faces as the lid does
  Cell& cell = s.boundary.cell;
  cell.rate.diagonal() << 7, 8, 9;
  Loading loading;
  loading.initial_size = {2, 4, 6};
  CHECK(axis_rate(s, loading, 2) == -0.5);
  CHECK(axis_rate(s, loading, 0) == 2.5);
  cell.walled = true;
  CHECK(axis_rate(s, loading, 0) == 3.5);
  CHECK(axis_rate(s, loading, 1) == 2);
  CHECK(axis_rate(s, loading, 2) == -0.5);
  s.boundary.walls.clear();
  cell.walled = false, cell.vectors = Mat3::Identity();
  CHECK(axis_rate(s, loading, 2) == 1.5);
}

TEST_CASE("dashpots that answer a rate more than its strain do not make a held stress swing") {
  Model model = linear_model(1e6, 0.8, 2650, 0);
  model.materials[0].restitution = 0.1;
  model.numerics.safety = 0.1;  // dashpots of spheres, which no estimate of the step counts, need a shorter one here
  make_pair_laws(model);
  State s = lattice(model, 1e-3);
  Team team(1);
  const double asked = 1.3 * normal_stresses(s)[0];
  Loading loading;
  loading.driven = loading.holds = true;
  loading.axes = {AxisControl{0, asked, 1e9}, AxisControl{0, asked, 1e9},
                  AxisControl{.strain_rate = -1e3, .stress = {}}};
  begin_loading(model, s, loading);
  // Corrected in each step, in which the dashpots press more than the springs that they ease.
  CHECK(s.servo.viscosity[0] > s.servo.stiffness[0] * s.dt);
  load(model, s, loading, s.time + 10 * s.dt, team);
  for (int k = 0; k < 40; ++k) {
    load(model, s, loading, s.time + s.dt, team);
    for (int axis = 0; axis < 2; ++axis) CHECK(normal_stresses(s)[axis] == Approx(asked).epsilon(2e-3));
  }
}
