// SPDX-License-Identifier: LGPL-3.0-or-later
// Steps that solve their contacts, against closed forms of implicit Euler and against explicit steps.
#include "dem/io/archive.hpp"
#include "dem/rve/implicit_stepper.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

Model implicit(Model model, double step = 0) {
  model.stepper = &implicit_stepper, model.numerics.time_step = step;
  return model;
}

/// Hulls that have been pressed together and have come to rest.
State pressed_cells(const Model& model, double share, Team& team) {
  const Tessellation cells = voronoi_packing(periodic_space(Vec3::Constant(4)), 60, 2, 5, team);
  State s;
  s.boundary.cell.vectors = 4 * Mat3::Identity();
  for (std::size_t i = 0; i < cells.body.size(); ++i) {
    Polyhedron body = cells.body[i];
    const Vec3 centre = moments_of(body).centre;
    place(body, Mat3::Identity(), -centre);
    add_body(s, body, centre, Quat::Identity());
  }
  Model damped = model;
  set_damping(damped, 0.4);
  prepare(damped, s, team);
  Mat3 rate = Mat3::Zero();
  rate.diagonal() << -0.3, -0.4, -0.5;
  set_cell_rate(s, share * rate);
  run_for(damped, s, 0.02, team);
  set_cell_rate(s, Mat3::Zero());
  run_for(damped, s, 0.3, team);
  return s;
}

struct Strained {
  Mat3 gained;   // Pa
  double error;  // of energy
  State state;
};

/// Axial strain of a rested state.
Strained strained(const Model& model, State s, double strain, double rate, Team& team) {
  const Mat3 before = measure(model, s).stress;
  Loading loading;
  loading.driven = true;
  loading.axes[2].strain_rate = -rate;
  s.next_estimate = s.steps, s.ledger = {};
  begin_loading(model, s, loading);
  load(model, s, loading, s.time + strain / rate, team);
  const Mat3 gained = measure(model, s).stress - before;
  return {gained, energy_error(s.ledger, stored_energy(model, s)), std::move(s)};
}

}  // namespace

TEST_CASE("a sphere on a spring moves as implicit Euler says") {
  const double k = 1e5, overlap = 1e-3, dt = 2e-3;
  const Model model = implicit(linear_model(k, 0.5, 1 / (4 * pi / 3), 0), dt);  // 1 kg at a radius of 1 m
  State s;
  add(s, PolyEllipsoid::sphere(1), Vec3(0, 0, 1 - overlap), 1 / (4 * pi / 3));
  add_floor(s);
  Team team(1);
  prepare(model, s, team);
  double v = 0, x = overlap;
  for (int n = 0; n < 5; ++n) {
    run_steps(model, s, 1, team);
    const double held = x > 0 ? x : 0;  // a contact that has parted presses no more
    v = held > 0 ? std::max((v + dt * k * held) / (1 + k * dt * dt), v + 0.0) : v;
    if (n == 0) {
      CHECK(v == Approx(1.0 / 7).epsilon(1e-12));
      CHECK(s.grains.motion[0].velocity.z() == Approx(1.0 / 7).epsilon(1e-4));
    }
    x -= dt * v;
  }
  const double error = energy_error(s.ledger, stored_energy(model, s));
  CHECK(std::abs(error) < 1e-3);
}

TEST_CASE("a cube slides down a slope as Coulomb says, and sticks below the angle of friction") {
  // k dt^2 / m is 0.4, 40 and 4,000: what slides must not part by friction x slip, 1e-3 to 10 times the overlap here.
  Team team(1);
  const double g = 9.81, c = 1e9, duration = 0.1;
  for (const double dt : {2e-5, 2e-4, 2e-3})
    for (const double degrees : {20.0, 30.0}) {
      const double angle = degrees * pi / 180, pressed = g * std::cos(angle);
      Model model = implicit(hull_model(0.5, c), dt);
      model.motion.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle));
      State s;
      add_body(s, unit_cube(), Vec3(0, 0, 0.5 - pressed / c), Quat::Identity());
      add_floor(s);
      prepare(model, s, team);
      run_for(model, s, duration, team);
      const double exact = std::max(0.0, (g * std::sin(angle) - 0.5 * pressed) * duration);
      const Motion& m = s.grains.motion[0];
      // It tilts on its springs at first, of which nothing is left at longer steps: 0.3 % of the speed at the end.
      CHECK(m.velocity.x() == Approx(exact).margin(degrees < 26 ? 2e-6 : 0.005 * exact));
      CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < (degrees < 26 ? 0.02 : 1e-3));
      if (degrees < 26) continue;
      // The way is longer than exact by a step; friction's own share of it, and no device's.
      CHECK(s.ledger.friction == Approx(0.5 * pressed * m.position.x()).epsilon(0.01));
      CHECK(std::abs(s.ledger.local_damping) < 0.01 * s.ledger.work);
    }
}

TEST_CASE("a sphere that hits a floor is not thrown back faster than it came, and its energy is told") {
  Team team(1);
  for (const double restitution : {1.0, 0.5}) {
    const double mass = 1, speed = 0.1;
    Model model = implicit(linear_model(1e5, 0.5, mass / (4 * pi / 3), 0));
    model.materials[0].restitution = restitution;
    make_pair_laws(model);
    State s;
    add(s, PolyEllipsoid::sphere(1), Vec3(0, 0, 1.0005), mass / (4 * pi / 3), -speed * Vec3::UnitZ());
    add_floor(s);
    prepare(model, s, team);
    s.ledger = {}, s.ledger.start = stored_energy(model, s);
    while (s.time < 0.05) {
      update_time_step(model, s);
      run_steps(model, s, 1, team);
    }
    const double back = s.grains.motion[0].velocity.z() / speed;
    CHECK(back > 0.1 * restitution);  // implicit Euler damps what is fast
    CHECK(back < restitution);
    // The dashpot sets in within a step: its trapezoid begins at nothing.
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < (restitution < 1 ? 0.05 : 1e-3));
    CHECK(s.ledger.local_damping > 0);
  }
}

TEST_CASE("a step whose forces are not found is refused with its residual") {
  Team team(1);
  const double mass = 1;
  Model model = implicit(linear_model(1e9, 0.5, mass / (4 * pi / 3), 0), 1);  // k dt^2 / m = 1e9
  model.motion.gravity = -9.81 * Vec3::UnitZ();
  State s;
  for (int n = 0; n < 2000; ++n)
    add(s, PolyEllipsoid::sphere(1), Vec3(0, 0, 1 + 2 * n - 1e-6 * (n + 1)), mass / (4 * pi / 3));
  add_floor(s);
  prepare(model, s, team);
  std::string told;
  try {
    run_steps(model, s, 1, team);
  } catch (const Unstable& e) {
    told = e.what();
  }
  CHECK_THAT(told, Catch::Matchers::Contains("not found in 2000 iterations (residual"));
}

TEST_CASE("pressed hulls gain the stress that explicit steps say, and the same laterally") {
  Team team(1);
  Model model = hull_model(0.5, 1e6, 0.3);
  const State rest = pressed_cells(model, 1, team);
  const double strain = 1e-3, rate = 0.05;
  const Strained explicitly = strained(model, rest, strain, rate, team);
  const Strained one = strained(implicit(model), rest, strain, rate, team);
  for (int k = 0; k < 3; ++k) CHECK(one.gained(k, k) == Approx(explicitly.gained(k, k)).epsilon(0.03));
  CHECK(std::abs(explicitly.error) < 0.01);
  CHECK(std::abs(one.error) < 0.01);
  CHECK(one.state.steps - rest.steps < (explicitly.state.steps - rest.steps) / 3);

  SECTION("with the same bits for any number of threads, and from any checkpoint") {
    Team three(3);
    CHECK(hash(strained(implicit(model), rest, strain, rate, three).state) == hash(one.state));
  }
}
