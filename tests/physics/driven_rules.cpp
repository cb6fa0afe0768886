// SPDX-License-Identifier: LGPL-3.0-or-later
// How fast walls and cells go that hold a stress, rule by rule, in closed form: one sphere that touches all six walls,
// and a cell whose stresses are set.
#include "dem/rve/press.hpp"
#include "dem/rve/servo.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double k = 1e6, density = 2500, side = 1.98, overlap = 0.01, rebound = 0.5;

Model springs() {
  Model model = linear_model(k, 0.8, density, 0);
  model.materials[0].restitution = rebound;
  make_pair_laws(model);
  return model;
}

/// A sphere of radius 1 in a box of 1.98.
State boxed(const Model& model) {
  State s;
  add(s, PolyEllipsoid::sphere(1), Vec3::Constant(0.5 * side), density);
  add_box(s, side);
  Team team(1);
  prepare(model, s, team);
  s.dt = 1e-3;
  return s;
}

Loading pressing(double stress) {
  Loading l;
  l.driven = l.holds = true, l.initial_size = Vec3::Constant(side);
  for (auto& axis : l.axes) axis = {.strain_rate = 0, .stress = -stress, .max_rate = 1e6};
  return l;
}

/// Speeds of the two walls across x, inward.
std::pair<double, double> inward(const Model& model, State s, const Loading& l) {
  press_walls(model, s, l);
  for (const Wall& wall : s.boundary.walls)
    for (int j = 0; j < 3; ++j)
      if (wall.facing()[j] == 0) CHECK(wall.velocity[j] == 0);
  return {s.boundary.walls[0].velocity.x(), -s.boundary.walls[1].velocity.x()};
}

/// Of the contacts with walls (N s/m).
double damping(const Model& model, const State& s) { return model.pairs[1].dashpot * std::sqrt(s.grains.mass[0] * k); }

}  // namespace

TEST_CASE("a wall that presses closes the gap to its force in a step, by the stiffness and the dashpot that it feels") {
  const Model model = springs();
  State s = boxed(model);
  const double area = side * side, felt = k * overlap, c = damping(model, s);
  for (const double share : {0.7, 1.3}) {  // what is pressed more stiffens as Hertz's contacts do
    const double force = share * felt, stiffness = k * (share > 1 ? std::cbrt(share) : 1);
    const auto [first, second] = inward(model, s, pressing(force / area));
    CHECK(first == Approx((force - felt) / (stiffness * s.dt + c)));
    CHECK(second == Approx(first));
  }
  // It goes with the grain, and what moves already needs to be no faster for that.
  s.grains.motion[0].velocity = Vec3(0.02, 0, 0), s.grains.motion[0].spin = Vec3(7, 8, 9);
  s.boundary.walls[0].velocity.x() = 0.03, s.boundary.walls[1].velocity.x() = -0.03;
  const double force = 0.7 * felt;
  Loading l = pressing(force / area);
  const double mass = s.grains.mass[0], rest = mass * 0.02 * std::sqrt(force / area / (mass / (side * area))) / side,
               brake = 0.5 * std::clamp(rest, -0.01 * force, 0.01 * force);  // half of what stops the drift
  const auto [first, second] = inward(model, s, l);
  CHECK(first == Approx(0.02 + (force - brake - felt + c * (0.03 - 0.02)) / (k * s.dt + c)));
  CHECK(second == Approx(-0.02 + (force + brake - felt + c * (0.03 + 0.02)) / (k * s.dt + c)));
}

TEST_CASE(
    "walls carry a weight and dead loads between them, half each, and gravity does not press on the axes across") {
  Model model = springs();
  State s = boxed(model);
  const double felt = k * overlap, area = side * side, c = damping(model, s), weight = 0.1 * felt;
  model.motion.gravity = Vec3(-weight / s.grains.mass[0], 0, 0);
  const auto [first, second] = inward(model, s, pressing(felt / area));
  CHECK(first == Approx(0.5 * weight / (k * std::cbrt(1.05) * s.dt + c)));
  CHECK(second == Approx(-0.5 * weight / (k * s.dt + c)));
  model.motion.gravity = Vec3(0, 0, 3);
  CHECK(std::abs(inward(model, s, pressing(felt / area)).first) < 1e-12);
  model.motion.gravity.setZero();
  DeadLoad load{};
  load.felt = Vec3(-weight, 0, 0);
  s.bonds.load.push_back(load);
  CHECK(inward(model, s, pressing(felt / area)).first == Approx(first));
}

TEST_CASE("a wall goes no faster than grains may follow, and looks for them where it touches none") {
  const Model model = springs();
  State s = boxed(model);
  const double area = side * side, felt = k * overlap;
  Loading l = pressing(30 * felt / area);
  for (auto& axis : l.axes) axis.max_rate = 0;
  const double most = 0.5 * side * 0.03 / inertial_number(s, 1, 30 * felt / area);  // at an inertial number of 0.03
  s.dt = 1e-9;
  s.boundary.walls[0].velocity.x() = 10;  // the dashpot feels a wall that comes fast
  CHECK(inward(model, s, l).first == Approx(most));
  s.boundary.walls[0].velocity.x() = s.grains.motion[0].velocity.x() = -5;  // outward, with the grain
  for (auto& axis : l.axes) axis.stress = -1e-3;
  const double slow = 0.5 * side * 0.03 / inertial_number(s, 1, felt / area);
  CHECK(inward(model, s, l).first == Approx(-5 - slow));
  for (double& stiffness : s.contacts.contact.stiffness) stiffness = 0;
  s.boundary.walls[0].velocity.setZero(), s.grains.motion[0].velocity.setZero();
  for (auto& axis : l.axes) axis.stress = -30 * felt / area, axis.max_rate = 1;  // faster than the grains
  CHECK(inward(model, s, l).first == Approx(0.05 * 0.5 * side));
  s.boundary.walls[0].velocity.x() = 0.3 * side;
  CHECK(inward(model, s, l).first == Approx((0.3 + 0.025) * side));
  s.boundary.walls[0].velocity.x() = 0.49 * side;
  CHECK(inward(model, s, l).first == Approx(0.5 * side));
  s.boundary.walls[0].velocity.x() = -0.3 * side;
  CHECK(inward(model, s, l).first == Approx(0.025 * side));
}

TEST_CASE("of an axis that is driven the first wall stays, and the far one follows its rate of the first size") {
  const Model model = springs();
  State s = boxed(model);
  Loading l = pressing(1e3);
  l.axes[0] = {.strain_rate = -0.5, .stress = {}}, l.initial_size.x() = 3;
  const auto [first, second] = inward(model, s, l);
  CHECK(first == 0);
  CHECK(second == Approx(0.5 * 3));
}

TEST_CASE("a mean stress is reached in proportion to time, and then kept by the two axes that are not driven") {
  Loading l;
  l.mean = -3e5, l.consolidation = 10;
  for (auto& axis : l.axes) axis = {.strain_rate = 0, .stress = -1, .max_rate = 7};
  l.axes[1] = {.strain_rate = -0.5, .stress = {}, .max_rate = 9};
  const Vec3 stress(-1e5, -5e5, -2e5);
  for (const auto& [time, sought] : {std::pair{2.0, -0.25 * 3e5}, {8.0, -3e5}, {9.0, -3e5}})
    for (const AxisControl& axis : controls(l, stress, time)) {
      CHECK(*axis.stress == Approx(sought));
      CHECK(axis.strain_rate == 0);
    }
  Loading from = l;  // a sample that is prepared has a pressure already
  from.prepared = -1e5;
  CHECK(*controls(from, stress, 0)[0].stress == -1e5);
  CHECK(*controls(from, stress, 2)[0].stress == Approx(-1e5 - 0.25 * 2e5));
  CHECK(*controls(from, stress, 8)[0].stress == Approx(-3e5));
  const auto later = controls(l, stress, 10);
  CHECK((later[0].max_rate == 7 && !later[1].stress && later[1].strain_rate == -0.5));
  for (const std::size_t j : {0u, 2u}) {
    CHECK(*later[j].stress == Approx(0.5 * (-9e5 + 5e5)));
    CHECK(later[j].strain_rate == Approx(0.25));
  }
}

TEST_CASE("a cell that holds a stress closes its gap, learns what keeps it, and is corrected as often as it must be") {
  const Model model = springs();
  State s;  // no contacts: the stress is 0
  add(s, PolyEllipsoid::sphere(1), Vec3::Zero(), density);
  s.boundary.cell.vectors = 5 * Mat3::Identity();
  Team team(1);
  prepare(model, s, team);
  s.dt = 1e-4, s.time = 3;
  Loading l = pressing(2e4);
  l.axes[0] = {.strain_rate = -0.5, .stress = {}};
  l.axes[1].strain_rate = 0.01;
  const auto hold = [&](double elapsed) {
    s.servo = {
        .drift = Vec3(9, 0.1, -0.1), .stiffness = Vec3(1e6, 4e6, 1e5), .stale_at = s.steps + 1, .at = s.time - elapsed};
    std::uint64_t steps = 0;
    const Vec3 rates = servo_rates(model, s, l, steps);
    return std::pair{rates, steps};
  };
  // The softer of the two is no softer than ten times its stress: 2e5 Pa, whose stress changes by 0.02 of itself in a
  // strain of 2e4 / 4e6 * 0.02, which the driven axis goes in two steps.
  const auto [rates, steps] = hold(1);
  CHECK(steps == 2);
  const double closing = 2e-4, one = -2e4 / (4e6 * closing), other = -2e4 / (2e5 * closing);
  CHECK(rates[0] == -0.5);
  CHECK(rates[1] == Approx(0.01 + 0.1 + 2 * one));  // all of it is learned after so long
  CHECK(rates[2] == Approx(-0.1 + 2 * other));
  CHECK(s.servo.drift[2] == Approx(-0.1 + other));
  CHECK(s.servo.at == s.time);
  const auto quick = hold(closing).first;  // an eighth of the gap is learned in one closing
  CHECK(quick[1] == Approx(0.01 + 0.1 + (1 + 1 / 8.0) * one));
  l.axes[0].strain_rate = -1e-9;
  CHECK(hold(1).second == servo_steps);
  l.axes[0].strain_rate = -1e9;
  CHECK(hold(1).second == 1);
  l.axes[0].strain_rate = -0.5, l.axes[1].max_rate = l.axes[2].max_rate = 0;
  const double most = 0.03 / inertial_number(s, 1, 2e4);
  CHECK(hold(1).first[2] == Approx(-most));
  CHECK(s.servo.drift[2] == Approx(-most));
}
