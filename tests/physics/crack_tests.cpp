// SPDX-License-Identifier: LGPL-3.0-or-later
// Which grains peridynamics is asked about, and what becomes of its answers: screens, memory of what has held, threads,
// what is saved.
#include "dem/rve/crack_tests.hpp"

#include <numbers>

#include "dem/rve/state_hash.hpp"
#include "tests/cracking_balls.hpp"
#include "tests/loaded_body.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// A ball of unit radius under two forces of that share of its platen strength, and a third that unbalances it.
State pressed_ball(const Model& model, double share, double third = 0) {
  const double force = share * crushing * 4;
  PointLoads loads{{Vec3(0, 0, 0.95), Vec3(0, 0, -force)}, {Vec3(0, 0, -0.95), Vec3(0, 0, force)}};
  if (third > 0) loads.emplace_back(Vec3(0.95, 0, 0), Vec3(-third * force, 0, 0));
  return loaded_body(model, ball_of_planes(Vec3::Ones()).body, loads);
}

void press_on(State& s, double factor) {
  for (DeadLoad& load : s.bonds.load) load.force *= factor, load.felt *= factor;
}

}  // namespace

TEST_CASE("a ball between two forces is looked at from the screen on, holds, is left alone, and falls to pieces") {
  Team team(1);
  const Model model = cracking_rock(crushing);
  State low = pressed_ball(model, 0.44);
  CHECK(find_breaks(model, low, team).empty());
  CHECK(low.ledger.cracks.tests == 0);
  CHECK(low.grains.utilisation[0] == Approx(0.44).epsilon(1e-9));
  State s = pressed_ball(model, 0.6);
  CHECK(find_breaks(model, s, team).empty());
  CHECK(s.ledger.cracks.tests == 1);
  CHECK(s.ledger.cracks.holds == 1);
  CHECK(s.grains.held[0].contacts == 2);
  CHECK(s.grains.held[0].moment.norm() == Approx(0.6 * crushing * 4 * 1.9).epsilon(1e-9));
  press_on(s, 1.04);  // force x arm of both together is 1.9 of each: by 0.1 of the radius, a change of 0.053
  CHECK(find_breaks(model, s, team).empty());
  CHECK(s.ledger.cracks.tests == 1);
  press_on(s, 1.03);
  CHECK(find_breaks(model, s, team).empty());
  CHECK(s.ledger.cracks.tests == 2);
  CHECK(s.ledger.cracks.holds == 2);
  press_on(s, 2);
  const std::vector<Break> breaks = find_breaks(model, s, team);
  REQUIRE(breaks.size() == 1);
  REQUIRE(breaks[0].pieces);
  CHECK(s.ledger.cracks.cracks == 1);
  CHECK(s.ledger.cracks.stalled == 0);
  CHECK(s.ledger.cracks.bond_energy > 0);
  const double mass = total_mass(s.grains);
  apply_breaks(model, s, breaks, team);
  CHECK(s.grains.size() == breaks[0].pieces->piece.size());
  CHECK(s.grains.size() >= 2);
  CHECK(std::abs(total_mass(s.grains) / mass - 1) < 1e-12);
  CHECK(s.ledger.fracture_area > 2);  // of a disc 3.1
  for (const HeldLoad& held : s.grains.held) CHECK(held.contacts == 0);
  // Energy of broken bonds against toughness x area of the faces (design: 1 to 4).
  const CrackTests& c = *model.materials[0].fracture->cracks;
  const double ratio = s.ledger.cracks.bond_energy / (2 * c.toughness.energy * s.ledger.fracture_area);
  CHECK(ratio > 0.5);
  CHECK(ratio < 6);
}

TEST_CASE("a ball that lies anyhow holds and cracks as it does upright") {
  Team team(1);
  const Model model = cracking_rock(crushing);
  for (std::uint64_t k = 0; k < 6; ++k) {
    const Mat3 turn = random_rotation(11, k).toRotationMatrix();
    for (const double share : {0.6, 1.3}) {
      Polyhedron body = ball_of_planes(Vec3(1, 0.9, 1.1)).body;
      place(body, turn, Vec3::Zero());
      const double force = share * crushing * 4;
      State s = loaded_body(
          model, body,
          {{turn * Vec3(0, 0, 1.04), turn * Vec3(0, 0, -force)}, {turn * Vec3(0, 0, -1.04), turn * Vec3(0, 0, force)}});
      const bool cracks = !find_breaks(model, s, team).empty();
      CHECK(s.ledger.cracks.tests == 1);
      CHECK(cracks == (share > 1));
      if (!cracks) continue;
      s.grains.strength[0] = 2.2;  // twice as strong: 0.59 of what it bears
      CHECK(find_breaks(model, s, team).empty());
      CHECK(s.ledger.cracks.holds == 1);
    }
  }
}

TEST_CASE("a grain in motion is not tested, nor is one that is too small or may not break again") {
  Team team(1);
  Model model = cracking_rock(crushing);
  const auto tests = [&](State s) {
    find_breaks(model, s, team);
    return s.ledger.cracks.tests;
  };
  CHECK(tests(pressed_ball(model, 0.6)) == 1);
  // A third force of t unbalances by 3 t / (2 + t) of the mean: 0.0199, 0.0201.
  CHECK(tests(pressed_ball(model, 0.6, 0.01335)) == 1);
  CHECK(tests(pressed_ball(model, 0.6, 0.0135)) == 0);
  CHECK(tests(pressed_ball(model, 0.6, 0.05)) == 0);
  model.materials[0].fracture->cracks->unbalanced_force = INFINITY;
  CHECK(tests(pressed_ball(model, 0.6, 0.05)) == 1);
  model.materials[0].fracture->limit.smallest_radius = 1.01;
  CHECK(tests(pressed_ball(model, 0.6)) == 0);
  model.materials[0].fracture->limit = {.max_generations = 0};
  CHECK(tests(pressed_ball(model, 0.6)) == 0);
  model.materials[0].fracture->limit = {};
  model.materials[0].fracture->cracks->force_screen = 0.61;
  CHECK(tests(pressed_ball(model, 0.6)) == 0);
}

TEST_CASE("grains crack to the same bits on any team, and from what is saved; what is cracked balances") {
  Model model = cracking_rock(4000, 300);
  CrackTests& c = *model.materials[0].fracture->cracks;
  c.unbalanced_force = c.unbalanced_moment = INFINITY;
  model.materials[0].fracture->limit.max_generations = 2;
  const State s = crushed(model, 1, 30);
  CHECK(s.ledger.cracks.cracks >= 4);
  CHECK(s.ledger.cracks.holds >= 1);
  CHECK(s.ledger.cracks.tests == s.ledger.cracks.cracks + s.ledger.cracks.holds + s.ledger.cracks.stalled);
  CHECK(s.ledger.breakages == s.ledger.cracks.cracks);
  for (const int threads : {2, 3}) {
    const State other = crushed(model, threads, 30);
    CHECK(hash(other) == hash(s));
    CHECK(bytes_of(other) == bytes_of(s));
  }
  CHECK(hash(crushed(model, 2, 30, true)) == hash(s));
  const double ball = 4 * std::numbers::pi / 3;
  CHECK(std::abs(total_mass(s.grains) / (27 * ball) - 1) < 1e-11);
  CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 0.02);
}

TEST_CASE("no grain that the screens leave out would have failed") {
  Team team(1);
  const Model model = cracking_rock(crushing, 300);
  Model all = model;
  CrackTests& open = *all.materials[0].fracture->cracks;
  open.force_screen = open.lattice.core_screen = 0;
  std::size_t left_out = 0, failed = 0;
  for (std::uint64_t k = 0; k < 40; ++k) {  // two to seven forces towards the middle that balance, small to too large
    PointLoads loads;
    Vec3 sum = Vec3::Zero();
    const auto normal = [&](std::uint64_t n) { return random_rotation(5, 100 * k + n) * Vec3::UnitZ(); };
    for (std::uint64_t n = 0; n < 1 + k % 6; ++n) {
      loads.emplace_back(0.95 * normal(n), -normal(n));
      sum -= normal(n);
    }
    loads.emplace_back(0.95 * sum.normalized(), -sum);
    double largest = 0;
    for (const auto& [at, force] : loads) largest = std::max(largest, force.norm());
    const double share = 0.3 + 1.2 * random_uniform(6, k, Purpose::strength);
    for (auto& [at, force] : loads) force *= share * crushing * 4 / largest;
    State screened = loaded_body(model, ball_of_planes(Vec3::Ones()).body, loads), unscreened = screened;
    const bool some = !find_breaks(model, screened, team).empty(), every = !find_breaks(all, unscreened, team).empty();
    INFO("loads " << loads.size() << " share " << share);
    CHECK(some == every);
    REQUIRE(unscreened.ledger.cracks.tests == 1);
    failed += every, left_out += screened.ledger.cracks.tests == 0 || !some;
  }
  CHECK(failed >= 8);
  CHECK(left_out > 15);
}

TEST_CASE("balls that all crack in one instant: mass, momentum and energy are kept, any threads") {
  const Model model = cracking_rock(crushing, 300);
  const auto broken = [&](int threads) {
    Team team(threads);
    State s;
    for (int n = 0; n < 27; ++n) {
      const Vec3 at = 3 * Vec3(n % 3, n / 3 % 3, n / 9);
      const std::size_t i =
          add_body(s, ball_of_planes(Vec3::Ones()).body, at, random_rotation(3, static_cast<std::uint64_t>(n)),
                   random_vector(8, 2), Vec3::Zero());
      for (const double side : {-1.0, 1.0}) {
        DeadLoad load{static_cast<Index>(i), s.grains.orientation[i].conjugate() * Vec3(0, 0, 0.95 * side),
                      Vec3(0, 0, -1.4 * side * crushing * 4)};
        load.point = at + Vec3(0, 0, 0.95 * side);
        s.bonds.load.push_back(load);
      }
    }
    prepare(model, s, team);
    s.dt = 1e-12;
    run_steps(model, s, 1, team);
    const Grains before = s.grains;
    const double error = told_energy_error(s, stored_energy(model, s));
    const std::vector<Break> breaks = find_breaks(model, s, team);
    REQUIRE(breaks.size() == 27);
    apply_breaks(model, s, breaks, team);
    CHECK(s.grains.size() >= 54);
    CHECK(std::abs(total_mass(s.grains) / total_mass(before) - 1) < 1e-12);
    CHECK((momentum(s.grains) - momentum(before)).norm() < 1e-12 * momentum(before).norm());
    CHECK(std::abs(kinetic_energy(s.grains) / kinetic_energy(before) - 1) < 1e-12);
    CHECK(std::abs(told_energy_error(s, stored_energy(model, s)) - error) < 1e-9);
    return hash(s);
  };
  CHECK(broken(1) == broken(3));
}

TEST_CASE("grains at the seam of a cell crack as they do within it") {
  const Model whole = hull_model(0.5);
  Model model = cracking_rock(1, 300);
  CrackTests& c = *model.materials[0].fracture->cracks;
  c.unbalanced_force = c.unbalanced_moment = INFINITY;
  const State pressed = crushed(whole, 1, 30);
  const auto broken = [&](const Vec3& shift) {
    Team team(2);
    State s = pressed;
    for (Motion& m : s.grains.motion) m.position += shift;
    prepare(model, s, team);
    const std::vector<Break> breaks = find_breaks(model, s, team);
    apply_breaks(model, s, breaks, team);
    return std::pair(std::move(s.grains), breaks.size());
  };
  const auto [within, cracks] = broken(Vec3::Zero());
  CHECK(cracks > 10);
  const auto [moved, again] = broken(Vec3(0.9, 1.7, -0.8));  // others lie at the seam
  CHECK(again == cracks);
  REQUIRE(moved.size() == within.size());
  for (std::size_t i = 0; i < within.size(); ++i) CHECK(moved.mass[i] == Approx(within.mass[i]).epsilon(1e-6));
}

TEST_CASE("a plate too thin for points is asked, left whole and counted, and asked again where its load has grown") {
  Team team(1);
  const Model model = cracking_rock(crushing, 300);
  const Vec3 half(0.5, 0.5, 0.02);
  State thin = loaded_body(model, box_between(-half, half),
                           {{Vec3(0.2, 0, 0.02), Vec3(0, 0, -400)}, {Vec3(0.2, 0, -0.02), Vec3(0, 0, 400)}});
  CHECK(find_breaks(model, thin, team).empty());
  CHECK(thin.ledger.cracks.stalled == 1);
  CHECK(find_breaks(model, thin, team).empty());
  CHECK(thin.ledger.cracks.tests == 1);
  press_on(thin, 10);
  CHECK(find_breaks(model, thin, team).empty());
  CHECK(thin.ledger.cracks.stalled == 2);
}

TEST_CASE("a break carries the points of its grain if they are asked for: dilations and stretches of what has moved") {
  Team team(1);
  for (const bool asked : {false, true}) {
    Model model = cracking_rock(crushing, 300);
    CrackTests& tests = *model.materials[0].fracture->cracks;
    tests.lattice.tells_points = asked, tests.lattice.keep_patches = false;
    State s = pressed_ball(model, 1.5);
    const std::vector<Break> breaks = find_breaks(model, s, team);
    REQUIRE(breaks.size() == 1);
    REQUIRE((breaks[0].lattice != nullptr) == asked);
    if (!asked) continue;
    const CrackedLattice& l = *breaks[0].lattice;
    const std::size_t n = l.points.size();
    REQUIRE(n > 250);
    REQUIRE((l.damage.size() == n && l.moved.size() == n && l.dilation.size() == n && l.piece.size() == n));
    const double d = s.grains.extent[0].equivalent_radius * 2;
    const double limit = tests.toughness.stretch(tests.lattice.lattice, tests.lattice.youngs_modulus,
                                                 tests.lattice.poissons_ratio, d, s.grains.strength[0]);
    const double horizon = tests.lattice.lattice.horizon;
    double longest = 0, largest = 0, worst = 0;  // stretch of whole bonds, dilation, and how far one is off
    std::size_t whole = 0;
    for (std::size_t i = 0; i < n; ++i) {
      double weighted = 0, sum = 0, all = 0, over = 0;
      for (std::size_t j = 0; j < n; ++j) {
        const Vec3 to = l.points[j] - l.points[i];
        const double length = to.norm() / l.spacing, share = std::min(1.0, horizon + 0.5 - length);
        if (i == j || share < 1e-9) continue;
        const double stretch = to.dot(l.moved[j] - l.moved[i]) / to.squaredNorm();
        weighted += share * length * length, sum += share * length * length * stretch;
        all += share, over += stretch > limit * (1 + 1e-9) ? share : 0;
        if (l.damage[i] == 0) longest = std::max(longest, stretch);
      }
      CHECK(l.damage[i] > over / all - 1e-9);  // what is too long is broken
      if (l.damage[i] > 0) continue;
      ++whole, largest = std::max(largest, std::abs(l.dilation[i]));
      worst = std::max(worst, std::abs(l.dilation[i] - 3 * sum / weighted));
    }
    CHECK(whole > 5);
    CHECK(worst < 1e-9 * largest);
    CHECK(longest <= limit * (1 + 1e-9));
    CHECK(longest > 0.5 * limit);
    // The ends come nearer to one another, whichever way the grain's frame lies.
    double upper = 0, lower = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double z = (s.grains.orientation[0] * l.points[i]).z(), u = (s.grains.orientation[0] * l.moved[i]).z();
      if (z > 0.75) upper = std::min(upper, u);
      if (z < -0.75) lower = std::max(lower, u);
    }
    CHECK((upper < 0 && lower > 0));
  }
}

TEST_CASE("a model that is tested for no cracks has no column of it") {
  Team team(1);
  const Model model = hull_model();
  State s;
  add_body(s, unit_cube(), Vec3::Zero(), Quat::Identity());
  prepare(model, s, team);
  CHECK(s.grains.held.empty());
  CHECK(!model.tests_cracks());
  CHECK(cracking_rock(1).tests_cracks());
}
