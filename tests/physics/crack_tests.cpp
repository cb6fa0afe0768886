// SPDX-License-Identifier: LGPL-3.0-or-later
// Which grains peridynamics is asked about, and what becomes of its answers: screens, memory of what has held, threads,
// what is saved.
#include "dem/rve/crack_tests.hpp"

#include <numbers>

#include "dem/fracture/platens.hpp"
#include "dem/io/archive.hpp"
#include "dem/packing/random_hulls.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/bonded.hpp"
#include "tests/hulls.hpp"
#include "tests/loaded_body.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// Rock whose balls break at `strength` (Pa, force over square of diameter) between platens.
Model cracking_rock(double strength, int points = 500) {
  Model model = hull_model(0.5);
  FractureModel f;
  CrackTests c;
  c.lattice.lattice.points = points;
  c.lattice.youngs_modulus = 60e9, c.lattice.poissons_ratio = 0.15;
  c.toughness.reference_diameter = 1;
  const double horizon = c.lattice.lattice.horizon * c.lattice.lattice.spacing();
  const double stretch = strength / (platen_number(c.lattice) * c.lattice.youngs_modulus);
  c.toughness.energy = fracture_energy(c.toughness.form, stretch, c.lattice.youngs_modulus, 0.15, horizon);
  f.criteria.emplace_back(PlatenForce{strength});
  f.splitter = Shatter{};
  f.cracks = c;
  model.materials[0].fracture = f;
  return model;
}

constexpr double crushing = 1e3;  // Pa

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

/// Balls of 32 planes, turned at random, on a cubic lattice in which each presses six others, pressed and sheared on.
State crushed(const Model& model, int threads, std::uint64_t steps, bool saved = false) {
  Team team(threads);
  State s;
  constexpr int side = 3;
  constexpr double apart = 1.93;  // radii of the ball's volume: its planes lie at 0.951
  s.boundary.cell.vectors = side * apart * Mat3::Identity();
  for (int n = 0; n < side * side * side; ++n) {
    const Vec3 at = apart * (Vec3(n % side, n / side % side, n / side / side) - Vec3::Ones());
    add_body(s, ball_of_planes(Vec3::Ones()).body, at, random_rotation(3, static_cast<std::uint64_t>(n)));
  }
  prepare(model, s, team);
  Mat3 rate = Mat3::Zero();
  rate(2, 2) = -2, rate(0, 1) = 1;
  set_cell_rate(s, rate);
  for (std::uint64_t done = 0; done < steps;) {
    if (saved && done > steps / 2) s = state_of(bytes_of(s)), saved = false;
    update_time_step(model, s);
    done += run_steps(model, s, std::min<std::uint64_t>(10, steps - done), team);
  }
  return s;
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

TEST_CASE("grains that crack are kept point by point where they are, as many as are asked for") {
  Team team(1);
  Model model = cracking_rock(crushing, 300);
  for (const std::size_t asked : {std::size_t{0}, std::size_t{1}}) {
    model.records_cracks = asked;
    State s = pressed_ball(model, 1.5);
    s.time = 3;
    REQUIRE(find_breaks(model, s, team).size() == 1);
    REQUIRE(s.break_room.cracked.size() == asked);
    if (asked == 0) continue;
    const CrackedGrain& cracked = s.break_room.cracked[0];
    const CrackedLattice& l = cracked.lattice;
    CHECK(cracked.number == 0);
    CHECK(cracked.id == s.grains.id[0]);
    CHECK(cracked.time == 3);
    CHECK(cracked.position == s.grains.motion[0].position);
    REQUIRE(l.points.size() > 250);
    REQUIRE(l.damage.size() == l.points.size());
    REQUIRE(l.moved.size() == l.points.size());
    REQUIRE(l.dilation.size() == l.points.size());
    // The ends come nearer to one another, whichever way the grain's frame lies, and the middle of all hardly moves.
    double upper = 0, lower = 0;
    Vec3 middle = Vec3::Zero();
    for (std::size_t i = 0; i < l.points.size(); ++i) {
      const Vec3 x = cracked.axes * l.points[i], u = cracked.axes * l.moved[i];
      middle += u / static_cast<double>(l.points.size());
      if (x.z() > 0.75) upper = std::min(upper, u.z());
      if (x.z() < -0.75) lower = std::max(lower, u.z());
    }
    CHECK(upper < 0);
    CHECK(lower > 0);
    CHECK(middle.norm() < 0.1 * (lower - upper));
    State second = pressed_ball(model, 1.5);
    second.ledger.cracks.cracks = 1;
    CHECK(find_breaks(model, second, team).size() == 1);
    CHECK(second.break_room.cracked.empty());
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
