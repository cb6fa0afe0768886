// SPDX-License-Identifier: LGPL-3.0-or-later
// Resistance to rolling against closed forms: an elastic-plastic couple between grains, and between grains and walls.
#include "dem/contact/forces.hpp"
#include "dem/motion/critical_step.hpp"
#include "dem/rve/measure.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double kn = 1e6, ratio = 0.8, kt = ratio * kn, R = 5e-3, density = 2600;
const double mass = density * 4 / 3 * pi * R * R * R;

Model rolling_model(double rolling, double friction) {
  Model model = linear_model(kn, ratio, density, friction);
  model.materials[0].rolling_friction = rolling;
  make_pair_laws(model);
  return model;
}

/// A sphere that rests on the floor under `gravity`, and may roll: v = spin x R.
State resting_sphere(const Model& model, double speed, double spin, Team& team) {
  State s;
  const double overlap = mass * -model.motion.gravity.z() / kn;
  add(s, PolyEllipsoid::sphere(R), Vec3(0, 0, R - overlap), density, Vec3(speed, 0, 0), Vec3(0, spin, 0));
  add_floor(s);
  prepare(model, s, team);
  return s;
}

double energy_of(const Model& model, const State& s) {
  const Measurement m = measure(model, s);
  return m.kinetic + m.elastic;
}

}  // namespace

TEST_CASE("a sphere that rolls on a plane is slowed by 5/7 of mu_r g, and what it had is what rolling took") {
  const double mu = 0.02, g = 9.81, speed = 0.5;
  Model model = rolling_model(mu, 0.5);
  model.motion.gravity = Vec3(0, 0, -g);
  Team team(1);
  State s = resting_sphere(model, speed, speed / R, team);
  const double before = energy_of(model, s), slowing = 5.0 / 7 * mu * g, stop = speed / slowing;
  run_for(model, s, 0.5 * stop, team);
  // The spring is full after mu m g / kt of its path, some 1e-7 of the way; the arm of friction is shorter than R by
  // half the overlap of 1e-8.
  CHECK(s.grains.motion[0].velocity.x() == Approx(0.5 * speed).epsilon(1e-4));
  CHECK(s.grains.motion[0].spin.y() * R == Approx(0.5 * speed).epsilon(1e-4));
  run_for(model, s, 0.6 * stop, team);
  CHECK(s.grains.motion[0].position.x() == Approx(0.5 * speed * speed / slowing).epsilon(1e-4));
  CHECK(std::abs(s.grains.motion[0].velocity.x()) < 1e-3 * speed);  // the spring lets it swing about where it stands
  CHECK(s.ledger.friction == Approx(before - energy_of(model, s)).epsilon(1e-5));
  CHECK(std::abs(s.ledger.unexplained) < 1e-9 * s.ledger.friction);
}

TEST_CASE("on a slope below mu_r a sphere stays, beyond it rolls with 5/7 of what is left") {
  const double mu = 0.2, g = 9.81;
  for (const double slope : {0.15, 0.19, 0.21, 0.4}) {
    Model model = rolling_model(mu, 0.8);
    const double angle = std::atan(slope), time = 0.02;
    model.motion.gravity = Vec3(g * std::sin(angle), 0, -g * std::cos(angle));
    Team team(1);
    State s = resting_sphere(model, 0, 0, team);
    run_for(model, s, time, team);
    const double v = s.grains.motion[0].velocity.x(), a = 5.0 / 7 * g * (std::sin(angle) - mu * std::cos(angle));
    // Set on a slope at once, the spring overshoots to twice its deflection: near its limit it gives once and holds.
    const double swing = 2 * g * std::sqrt(1.4 * mass / kt);
    INFO("slope " << slope << ", v " << v);
    if (slope < mu)
      CHECK(std::abs(v) < swing);
    else
      CHECK(v == Approx(a * time).margin(swing));
  }
}

TEST_CASE("below its limit a sphere rocks at the frequency of two springs, and the time step knows the other one") {
  // x, q = R theta; m x'' = -kt (x - q), 0.4 m q'' = kt (x - q) - kt q: eigenvalues of 0.4 l^2 - 2.4 l + 1 = 0.
  const double slow = (2.4 - std::sqrt(5.76 - 1.6)) / 0.8, fast = (2.4 + std::sqrt(5.76 - 1.6)) / 0.8;
  Model model = rolling_model(10, 10);
  model.motion.gravity = Vec3(0, 0, -9.81);
  Team team(1);
  const double v = 1e-4;
  State s = resting_sphere(model, v, (1 - slow) * v / R, team);
  const CriticalStep critical = critical_step(model.law, model.pairs, 2, s.grains, s.boundary, s.contacts, s.bonds);
  CHECK(critical.dt == Approx(2 / std::sqrt(fast * kt / mass)).epsilon(1e-4));
  const double start = energy_of(model, s);
  double crossed = 0, last = 0;
  int crossings = 0;
  for (int k = 0; crossings < 5 && k < 200000; ++k) {
    run_steps(model, s, 1, team);
    const double x = s.grains.motion[0].position.x();
    if (last * x < 0 && last < 0) {  // upwards: a period each
      const double at = s.time - s.dt * x / (x - last);
      if (crossings++ == 0) crossed = at;
      if (crossings == 5) CHECK((at - crossed) / 4 == Approx(2 * pi / std::sqrt(slow * kt / mass)).epsilon(3e-3));
    }
    last = x;
  }
  CHECK(crossings == 5);
  CHECK(energy_of(model, s) == Approx(start).epsilon(1e-2));  // of the leapfrog at 0.3 of its critical step
  CHECK(s.ledger.friction < 1e-9 * start);
}

TEST_CASE(
    "two spheres of other sizes that roll on each other keep their angular momentum; the couple ends at its limit") {
  const double mu = 0.1, r = 0.4 * R;
  Model model = rolling_model(mu, 0.9);
  State s;
  const double overlap = 1e-4 * R;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), density, Vec3::Zero(), Vec3(0, 3, 0));
  add(s, PolyEllipsoid::sphere(r), Vec3(R + r - overlap, 0, 0), density, Vec3::Zero(), Vec3(0, -7, 2));
  Team team(1);
  prepare(model, s, team);
  auto momentum = [&] {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < 2; ++i) {
      const Motion& m = s.grains.motion[i];
      sum += m.position.cross(m.velocity) / m.inverse_mass + m.spin / m.inverse_inertia;
    }
    return sum;
  };
  const Vec3 start = momentum();
  const double before = energy_of(model, s);
  double most = 0;
  for (int k = 0; k < 20; ++k) {
    run_steps(model, s, 3, team);
    const Contact c = s.contacts.contact[0];
    const Touch& t = s.contacts.touch[0];
    if (c.stiffness == 0) break;
    const double limit = mu * t.force.dot(t.normal);
    CHECK(c.radius == Approx(R * r / (R + r)).epsilon(1e-12));
    CHECK(c.spring[roll_spring].norm() <= limit * (1 + 1e-12));
    CHECK(std::abs(c.spring[roll_spring].dot(t.normal)) < 1e-4 * limit);  // a step's turn of the normal
    most = std::max(most, c.spring[roll_spring].norm() / limit);
  }
  CHECK(most > 0.999);
  // Of the couples nothing is left over; friction acts half an overlap off the line of centres.
  CHECK((momentum() - start).norm() < 1e-9 * start.norm());
  CHECK(s.ledger.friction > 0);
  CHECK(before - energy_of(model, s) == Approx(s.ledger.friction).margin(0.01 * before));
}

TEST_CASE(
    "rolling friction of a pair is the smaller one, the grain's against what is rigid, none where nothing slides") {
  Model model;
  Material rough = solid(60e9, 0.2, density, 0.5), smooth = solid(60e9, 0.2, density, 0.3), slippery = smooth, rigid;
  rough.rolling_friction = 0.2, smooth.rolling_friction = 0.1, slippery.rolling_friction = 0.3, slippery.friction = 0;
  rigid.youngs_modulus = INFINITY, rigid.friction = NAN;
  model.materials = {rough, smooth, slippery, rigid};
  make_pair_laws(model);
  auto of = [&](std::size_t a, std::size_t b) { return model.pairs[4 * a + b].friction[roll_spring]; };
  CHECK(of(0, 1) == 0.1);
  CHECK(of(1, 0) == 0.1);
  CHECK(of(0, 3) == 0.2);
  CHECK(of(3, 1) == 0.1);
  CHECK(of(0, 2) == 0);
  CHECK(of(2, 3) == 0);
  CHECK(model.springs()[roll_spring]);
  CHECK_FALSE(linear_model(kn, ratio, density, 0.5).springs()[roll_spring]);
}

TEST_CASE("a state that is turned takes its rolling springs along") {
  Model model = rolling_model(0.3, 0.5);
  Team team(1);
  State s = resting_sphere(model, 1e-3, 1e-3 / R, team);
  s.grains.motion[0].velocity = Vec3(1e-3, 0, 0);
  model.motion.gravity = Vec3(0, 0, -9.81);
  run_steps(model, s, 5, team);
  const Vec3 roll = s.contacts.contact[0].spring[roll_spring];
  REQUIRE(roll.norm() > 0);
  Mat3 quarter;
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  rotate(s, quarter);
  CHECK((s.contacts.contact[0].spring[roll_spring] - quarter * roll).norm() < 1e-14 * roll.norm());
}
