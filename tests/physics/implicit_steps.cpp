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
  CHECK_THAT(told, Catch::Contains("not found in 2000 iterations (residual"));
}

TEST_CASE("forces that change little in a step are found the better, and a step as short as it gets has more time") {
  Team team(1);
  State s;
  for (const double x : {0.0, 1.99}) add(s, PolyEllipsoid::sphere(1), Vec3(x, 0, 0), 1000);
  const Model spheres = implicit(model_of(solid(1e12, 0.2, 1000)));
  prepare(spheres, s, team);
  REQUIRE(s.contacts.touch[0].overlap == Approx(0.01));
  s.grains.motion[0].velocity.x() = 0.002;
  const double tenth = 0.1 * 0.01 / 0.002;  // s, until the overlap has grown by so much
  s.watch = StepWatch::on;
  for (const auto& [share, wish] : {std::pair(0.4, 0.4), {3.0, 1.0}, {0.001, 0.03}}) {
    const ConeSettings asked = accuracy_of(s, share * tenth);
    CHECK(asked.wish == Approx(wish));
    CHECK((asked.iterations == 2000 && asked.tolerance == 1e-4 && asked.by_overlap == 1e-3));
  }
  s.watch = StepWatch::off;
  CHECK(accuracy_of(s, 0.4 * tenth).iterations == 20000);
  CHECK(accuracy_of(s, 0.4 * tenth).wish == Approx(0.4));
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

TEST_CASE(
    "the step is halved or doubled at most towards the one in which contacts close by a tenth, and flights are a "
    "hundredth of a radius") {
  Team team(1);
  State s;
  for (const double x : {0.0, 1.99, 10.0}) add(s, PolyEllipsoid::sphere(1), Vec3(x, 0, 0), 1000);
  Model spheres = implicit(model_of(solid(1e12, 0.2, 1000)));
  prepare(spheres, s, team);
  REQUIRE(s.contacts.size() > 0);
  REQUIRE(s.contacts.contact.touching(0));
  const double overlap = s.contacts.touch[0].overlap;
  REQUIRE(overlap == Approx(0.01));
  const auto chosen = [&](const Model& m, double now, StepWatch watch) {
    s.dt = now, s.steps = 100, s.next_estimate = 100, s.watch = watch;
    update_time_step(m, s);
    return s.dt;
  };
  s.grains.motion[0].velocity = Vec3(2, 3, 0), s.grains.motion[1].velocity = Vec3(1.5, 3, 7);
  s.grains.motion[2].velocity.setZero();
  const double closing = 0.1 * overlap / 0.5, met = 0.01 * s.mean_radius / std::sqrt(1.5 * 1.5 + 9 + 49);
  REQUIRE(met < closing);  // by the fastest
  CHECK(chosen(spheres, 0.6 * met, StepWatch::on) == Approx(met));
  CHECK((s.next_estimate == 105 && s.estimate_interval == 5 && s.watch == StepWatch::on));
  CHECK(chosen(spheres, 0.1 * met, StepWatch::on) == Approx(0.2 * met));
  CHECK(chosen(spheres, 0.1 * met, StepWatch::asked) == Approx(0.1 * met));  // may not grow this time
  CHECK(s.watch == StepWatch::on);
  CHECK(chosen(spheres, 1.6 * met, StepWatch::on) == Approx(met));
  CHECK(chosen(spheres, 5 * met, StepWatch::on) == Approx(2.5 * met));
  CHECK(s.watch == StepWatch::on);
  CHECK(chosen(spheres, 5 * met, StepWatch::firmer) == Approx(2.5 * met));  // it was too long
  CHECK(chosen(spheres, 0.8 * met, StepWatch::firmer) == Approx(0.4 * met));
  // By the contact's way alone.
  s.grains.motion[0].velocity = Vec3(0.001, 0.002, 0), s.grains.motion[1].velocity = Vec3(-0.001, 0, 0);
  s.grains.motion[2].velocity.setZero();
  CHECK(chosen(spheres, 0.4, StepWatch::on) == Approx(0.1 * overlap / 0.002));
  spheres.numerics.max_time_step = 0.3;
  CHECK(chosen(spheres, 0.2, StepWatch::on) == Approx(0.3));
  spheres.numerics.max_time_step = 0;
  // No shorter than explicit steps are, and then it is as short as it gets.
  Model other = spheres;
  other.stepper = &explicit_stepper;
  State twin = s;
  twin.next_estimate = twin.steps;
  update_time_step(other, twin);
  CHECK(chosen(spheres, 1.2 * twin.dt, StepWatch::firmer) == Approx(twin.dt));
  CHECK(s.watch == StepWatch::off);
  spheres.numerics.time_step = 0.7;
  CHECK(chosen(spheres, 1, StepWatch::on) == 0.7);
  CHECK(s.next_estimate == std::numeric_limits<std::uint64_t>::max());
  s.steps = 5, s.next_estimate = 6, s.dt = 3;
  update_time_step(spheres, s);
  CHECK(s.dt == 3);  // not due
}

TEST_CASE("spheres of a moving cell meet by what its images do, and walls by what they do") {
  Team team(1);
  Model model = implicit(model_of(solid(1e7, 0.2, 1000)));
  State s;
  add(s, PolyEllipsoid::sphere(1), Vec3(5, 5, 0.99), 1000);
  add_floor(s);
  prepare(model, s, team);
  REQUIRE(s.contacts.contact.touching(0));
  s.boundary.walls[0].velocity = Vec3(5, 0, 0.001);
  s.grains.motion[0].velocity = Vec3(0, 0, -0.001);
  s.dt = 0.3, s.next_estimate = s.steps, s.watch = StepWatch::on;
  update_time_step(model, s);
  CHECK(s.dt == Approx(0.1 * 0.01 / 0.002));
  State cell;
  for (int i = 0; i < 4; ++i) add(cell, PolyEllipsoid::sphere(1), Vec3(1.99 * i, 0, 0), 1000);
  cell.boundary.cell.vectors = Vec3(4 * 1.99, 9, 9).asDiagonal();
  prepare(model, cell, team);
  cell.boundary.cell.rate(0, 0) = -0.004;  // the grains stand: the one contact across the seam closes by all of it
  cell.dt = 0.7, cell.next_estimate = cell.steps, cell.watch = StepWatch::on;
  update_time_step(model, cell);
  CHECK(cell.dt == Approx(0.1 * 4 * 0.01 / 0.004));  // overlaps and ways are means over the contacts' forces
}
