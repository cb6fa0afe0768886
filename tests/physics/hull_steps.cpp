// SPDX-License-Identifier: LGPL-3.0-or-later
// The critical step of hulls: how stiff their contacts are told to be, and that it is a bound; that of dashpots.
#include "dem/motion/critical_step.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/held_grains.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

TEST_CASE("loose hulls hardly below the critical step: by axis and by sharpness it is still a bound") {
  Team team(1);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Model model = loose(0);
    model.numerics.safety = 1;
    State s = pressed_cells(model, 60, 0.01, seed);
    prepare(model, s, team);
    run_for(model, s, 3000 * s.dt, team);
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.05);
    CHECK(stored_energy(model, s) < 1.05 * s.ledger.start);
  }
}

TEST_CASE("on a face, an edge and a corner a cube is as stiff as its force grows, by differences") {
  Team team(1);
  const Model model = loose(0);
  const Quat faces[] = {Quat::Identity(), Quat(Eigen::AngleAxisd(0.25 * pi, Vec3::UnitX())),
                        Quat::FromTwoVectors(Vec3::Ones(), Vec3::UnitZ())};
  for (const double d : {1e-3, 1e-2}) {
    double of_face = 0;
    for (int n = 2; n <= 4; ++n) {  // the potential's degree
      const double half = 0.5 * std::sqrt(n - 1.0);
      const auto pressed = [&](double overlap) {
        State s;
        add_body(s, unit_cube(), Vec3(0, 0, half - overlap), faces[n - 2]);
        add_floor(s);
        prepare(model, s, team);
        return s;
      };
      const auto force = [&](double overlap) { return pressed(overlap).contacts.touch[0].force.norm(); };
      const State s = pressed(d);
      const double stiffness = held_of(model, s).stiffness(0)(2, 2) * s.grains.mass[0], h = 1e-3 * d;
      CHECK(stiffness == Approx((force(d + h) - force(d - h)) / (2 * h)).epsilon(1e-5));
      CHECK(stiffness == Approx((n - 1) * force(d) / d).epsilon(1e-6));  // of degree n - 1
      if (n == 2) of_face = stiffness;
      if (n > 2) CHECK(stiffness < of_face);
    }
  }
}

TEST_CASE("faces hold each other once they lie on each other, or may within the time ahead") {
  Team team(1);
  const Model model = hull_model();
  const auto held = [&](double gap, double speed, double spin, double ahead) {
    State s;
    add_body(s, unit_cube(), Vec3::Zero(), Quat::Identity(), Vec3(0, 0, speed));
    add_body(s, unit_cube(), Vec3(0, 0, 1 + gap), Quat::Identity(), Vec3::Zero(), Vec3(0, 0, spin));
    prepare(model, s, team);
    const HeldGrains of(model.law, model.pairs, model.materials.size(), s.grains, s.boundary, s.contacts, s.bonds,
                        ahead, team);
    CHECK((of.touched()[0] != 0) == (of.stiffness(0)(2, 2) > 0));
    return of.stiffness(0)(2, 2);
  };
  constexpr double whole = 2 * modulus;  // a pair counts twice
  CHECK(held(0, 0, 0, 0) == Approx(whole).epsilon(1e-9));
  CHECK(held(1e-3, 0, 0, 1) == 0);
  CHECK(held(1e-3, 2, 0, 1e-3) == Approx(whole).epsilon(1e-9));
  CHECK(held(1e-3, -2, 0, 1e-3) == Approx(whole).epsilon(1e-9));  // it flies off, and may come back
  CHECK(held(1e-3, 2, 0, 4e-4) == 0);
  CHECK(held(1e-3, 0, 2 / std::sqrt(0.75), 1e-3) == Approx(whole).epsilon(1e-9));  // by the way of its corners
  CHECK(held(1e-3, 0, 1 / std::sqrt(0.75), 5e-4) == 0);
}

TEST_CASE("plates that meet face on ask for a new estimate at once, and once only where the step bears them") {
  Team team(1);
  const Vec3 half(0.5, 0.5, 0.01);
  for (const bool bears : {false, true}) {
    Model model = hull_model();
    model.numerics.safety = 0.5;
    if (bears) model.numerics.max_time_step = 1e-6;
    State s;
    add_body(s, box_between(-half, half), Vec3(0, 0, -0.02), Quat::Identity(), Vec3(0, 0, 0.01));
    add_body(s, box_between(-half, half), Vec3(0, 0, 0.02), Quat::Identity(), Vec3(0, 0, -0.01));
    s.boundary.cell.vectors = 10 * Mat3::Identity();
    prepare(model, s, team);
    update_time_step(model, s);
    s.next_estimate = 100000000;
    const double before = s.dt, most = model.numerics.safety * 2 / std::sqrt(2 * modulus / s.grains.mass[0]);
    if (!bears) CHECK(before > most);
    const std::uint64_t steps = static_cast<std::uint64_t>(1.05 / s.dt);
    CHECK((run_steps(model, s, steps, team) < steps) == !bears);
    CHECK((s.watch == StepWatch::asked) == !bears);
    if (bears) continue;
    CHECK(s.contacts.contact.touching(0));
    CHECK(s.next_estimate == s.steps);
    update_time_step(model, s);
    CHECK(s.watch == StepWatch::on);
    CHECK(s.dt == Approx(most).epsilon(1e-6));
    s.next_estimate = 100000000;
    CHECK(run_steps(model, s, 20, team) == 20);  // no stiffer: it does not ask again
  }
}

TEST_CASE("plates that have got mass and no moments ask at once, too: their faces turn faster what they shift slowly") {
  Team team(1);
  const Vec3 half(0.5, 0.5, 0.01);
  for (const bool both : {false, true}) {
    Model model = hull_model();
    State s;
    add_body(s, box_between(-half, half), Vec3(0, 0, -0.02), Quat::Identity(), Vec3(0, 0, 0.01));
    add_body(s, box_between(-half, half), Vec3(0, 0, 0.02), Quat::Identity(), Vec3(0, 0, -0.01));
    s.boundary.cell.vectors = 10 * Mat3::Identity();
    const double mass = s.grains.mass[0], moment = s.grains.inertia[0].moments.minCoeff();
    for (std::size_t i = 0; i < 2; ++i) set_inertia(s.grains, i, 1e4 * mass, (both ? 1e4 : 1) * mass);
    prepare(model, s, team);
    update_time_step(model, s);
    // What is allowed lies between: a unit face shifts at 2 c / m and turns, at most, at 2 c (1/6) / I.
    const double shifts = 2 * modulus / (1e4 * mass), turns = modulus / (3 * moment);
    s.dt = 2 * model.numerics.safety / std::pow(shifts * turns * turns, 1.0 / 6);
    s.next_estimate = 100000000;
    const std::uint64_t steps = static_cast<std::uint64_t>(1 / s.dt) + 6;  // before a turn that grows can be seen
    CHECK((run_steps(model, s, steps, team) < steps) == !both);
  }
}

TEST_CASE("plates whose turns the step bears hide none that meet beside them") {
  Team team(1);
  const Vec3 half(0.5, 0.5, 0.01);
  for (const bool meets : {false, true}) {
    const Model model = hull_model();
    State s;
    const double speed = meets ? 0.01 : 0;
    for (const double side : {-1.0, 1.0}) {
      add_body(s, box_between(-half, half), Vec3(0, 0, side * (0.01 - 5e-7)), Quat::Identity());
      add_body(s, box_between(-half, half), Vec3(3, 0, side * (0.01 + 6e-5)), Quat::Identity(),
               Vec3(0, 0, -side * speed));
    }
    s.boundary.cell.vectors = 10 * Mat3::Identity();
    const double mass = s.grains.mass[0];
    for (std::size_t i = 0; i < 4; ++i) set_inertia(s.grains, i, 1e4 * mass, mass);
    prepare(model, s, team);
    // By axis a plate turns at half of what the polar moment says: borne from the start, in spite of what it says.
    CHECK(s.contacts.contact.reach[0] > 1.5 * std::pow(2 * model.numerics.safety / s.dt, 2));
    s.next_estimate = 100000000;
    const std::uint64_t ran = run_steps(model, s, 150, team);
    CHECK((ran == 150) == !meets);
    CHECK((s.watch == StepWatch::asked) == meets);
    if (meets) CHECK(s.time == Approx(6e-5 / speed).epsilon(0.05));
  }
}

TEST_CASE("a face, its turns and a corner ask once they are a quarter stiffer than what was borne") {
  Team team(1);
  const Quat on_corner = Quat::FromTwoVectors(Vec3::Ones(), Vec3::UnitZ());
  for (const int kind : {0, 1, 2}) {
    Model model = hull_model();
    model.numerics.safety = 0.02;  // it hardly moves in a step
    const bool corner = kind == 2;
    State start;
    const double half = corner ? 0.5 * std::sqrt(3.0) : 0.5;
    add_body(start, unit_cube(), Vec3::Zero(), Quat::Identity());
    add_body(start, unit_cube(), Vec3(0, 0, 0.5 + half - 1e-3), corner ? on_corner : Quat::Identity());
    start.boundary.cell.vectors = 10 * Mat3::Identity();
    if (kind == 1)
      for (std::size_t i = 0; i < 2; ++i)
        set_inertia(start.grains, i, 1e4 * start.grains.mass[i], start.grains.mass[i]);
    prepare(model, start, team);
    start.dt = 2 * model.numerics.safety / std::sqrt(0.9 * start.contacts.contact.reach[0]);  // allows a tenth less
    start.next_estimate = 100000000;
    for (const double share : {1.2, 1.3}) {
      State s = start;
      s.contacts.contact.reach[0] /= share;
      CHECK((run_steps(model, s, 6, team) == 6) == (share < 1.25));
    }
  }
}

TEST_CASE("when an estimate is asked for does not hang on how a run is cut") {
  Team team(1);
  const Vec3 half(0.5, 0.5, 0.01);
  Model model = hull_model(0, modulus, 0.5);
  model.numerics.safety = 0.5, model.numerics.estimate_every = 1000000;
  const auto run = [&](std::uint64_t most) {
    State s;
    add_body(s, box_between(-half, half), Vec3(0, 0, -0.02), Quat::Identity(), Vec3(0, 0, 1), Vec3(0.3, 0, 0));
    add_body(s, box_between(-half, half), Vec3(0, 0, 0.02), Quat::Identity(), Vec3(0, 0, -1));
    s.boundary.cell.vectors = 3 * Mat3::Identity();
    prepare(model, s, team);
    s.next_estimate = 100000000;
    std::uint64_t asked = 0;
    while (s.steps < 600) {
      update_time_step(model, s);
      run_steps(model, s, std::min({most, 600 - s.steps, s.next_estimate - s.steps}), team);
      asked += s.watch == StepWatch::asked;
    }
    CHECK(asked > 0);
    return hash(s);
  };
  const auto whole = run(600);
  for (const std::uint64_t most : {1u, 2u, 7u}) CHECK(run(most) == whole);
}

TEST_CASE("dashpots of hulls bound the step in closed form: below it motion dies, above it grows") {
  Team team(1);
  Model model = hull_model(0, modulus, 0.1);
  model.numerics.max_energy_error = INFINITY;
  const auto pressed = [&](double off) {  // between floor and ceiling, `off` the middle
    State s;
    add_body(s, unit_cube(), Vec3(0, 0, 0.49 + off), Quat::Identity());
    add_floor(s);
    add_floor(s);
    s.boundary.walls[1].shape = PlaneWall{-Vec3::UnitZ()}, s.boundary.walls[1].point.z() = 0.98;
    return s;
  };
  State at_rest = pressed(0);
  prepare(model, at_rest, team);
  const CriticalStep critical = critical_step(held_of(model, at_rest), false);
  const double k = 2 * modulus, c = 2 * model.pairs[1].dashpot * std::sqrt(modulus);  // of a cube of 1 kg
  CHECK(c > 0.5 * std::sqrt(k));
  // k t^2 + 2 c t = 4 (motion along z; that of turns is slower).
  CHECK(critical.damped == Approx((std::sqrt(c * c + 4 * k) - c) / k).epsilon(1e-9));
  const auto swings = [&](double share) {
    model.numerics.time_step = share * critical.damped;
    State s = pressed(1e-6);
    prepare(model, s, team);
    run_for(model, s, 200 * model.numerics.time_step, team);
    return std::abs(s.grains.motion[0].position.z() - 0.49) / 1e-6;
  };
  CHECK(swings(0.97) < 0.1);
  CHECK(swings(1.03) > 10);
  model.numerics.time_step = 0, model.numerics.safety = 0.9;
  State s = pressed(0);
  prepare(model, s, team);
  CHECK(s.dt == Approx(0.8 * critical.damped).epsilon(1e-9));
  model.numerics.safety = 0.1;
  s = pressed(0);
  prepare(model, s, team);
  CHECK(s.dt == Approx(0.1 * critical.dt).epsilon(1e-9));
}

TEST_CASE("dashpots of a flat grain, whose normals pass by its middle, bound the step in closed form") {
  Team team(1);
  constexpr double kn = 1e6, a = 5e-4, b = 0.25 * a, deep = 1e-7 * a;
  Model model = linear_model(kn, 0, 2650, 0);
  model.materials[0].restitution = 0.1, model.numerics.max_energy_error = INFINITY;
  make_pair_laws(model);
  // Turned by 45 degrees between four walls that press alike, so that it stays.
  const double reach = std::sqrt(0.5 * (a * a + b * b)), lever = 0.5 * (a * a - b * b) / reach;
  const auto pressed = [&](double spin) {
    State s;
    add(s, {Vec3(a, a, b), Vec3(a, a, b)}, Vec3::Zero(), 2650, Vec3::Zero(), Vec3(0, spin, 0),
        Quat(Eigen::AngleAxisd(0.25 * pi, Vec3::UnitY())));
    for (const Vec3& n : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
      add_floor(s);
      s.boundary.walls.back().shape = PlaneWall{n}, s.boundary.walls.back().point = (deep - reach) * n;
    }
    return s;
  };
  State at_rest = pressed(0);
  prepare(model, at_rest, team);
  const double mass = at_rest.grains.mass[0], yields = lever * lever / (0.2 * mass * (a * a + b * b));
  const double dashpot = model.pairs[1].dashpot * std::sqrt(kn * mass), k = 4 * kn * yields, c = 4 * dashpot * yields;
  const double damped = critical_step(held_of(model, at_rest), false).damped;
  CHECK(damped == Approx((std::sqrt(c * c + 4 * k) - c) / k).epsilon(1e-5));  // k t^2 + 2 c t = 4
  const double slow = 1e-4 * kn * deep / (dashpot * lever);                   // all walls go on pressing
  const auto swings = [&](double share) {
    model.numerics.time_step = share * damped;
    State s = pressed(slow);
    prepare(model, s, team);
    run_for(model, s, 200 * model.numerics.time_step, team);
    return s.grains.motion[0].spin.norm() / slow;
  };
  CHECK(swings(0.97) < 0.1);
  CHECK(swings(1.03) > 10);
  model.numerics.time_step = 0;
  for (const double safety : {0.5, 0.9}) {  // the time step of both, whichever is shorter
    model.numerics.safety = safety;
    State s = pressed(0);
    prepare(model, s, team);
    CHECK(s.dt == Approx(std::min(safety * critical_step(held_of(model, s), false).dt, 0.8 * damped)).epsilon(1e-9));
    CHECK(s.dt < 0.99 * safety * critical_step(held_of(model, s), false).dt);
  }
}
