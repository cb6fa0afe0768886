// SPDX-License-Identifier: LGPL-3.0-or-later
// Contacts solved at once, against closed forms: sliding, stacks, impacts, springs, torsion, and what rigid ones leave
// open.
#include "dem/motion/cone_solver.hpp"

#include <cstring>
#include <random>

#include "tests/helpers.hpp"

using namespace grus::dem;

namespace {

constexpr double g0 = 9.81;  // m/s^2

ConeBody sphere(double mass, double radius) { return {1 / mass, Mat3::Identity() / (0.4 * mass * radius * radius)}; }

ConeBody box(double mass, const Vec3& sides) {
  const Vec3 s2 = sides.cwiseAbs2();
  return {1 / mass,
          Vec3(12 / (mass * (s2.y() + s2.z())), 12 / (mass * (s2.x() + s2.z())), 12 / (mass * (s2.x() + s2.y())))
              .asDiagonal()};
}

/// A body on what does not give way, which is below it.
ConeContact on_ground(Index body, const Vec3& arm, double friction) {
  return {.a = body, .normal = -Vec3::UnitZ(), .across = Vec3::UnitX(), .arm_a = arm, .friction = friction};
}

struct Solved {
  std::vector<ConeRows> impulse;
  ConeEnd end;
};

Solved solve(const std::vector<ConeBody>& bodies, const std::vector<ConeContact>& contacts, bool parts = false,
             double tolerance = 1e-10, std::vector<ConeRows> start = {}) {
  Team team(1);
  ConeSolver solver;
  start.resize(contacts.size(), ConeRows{});
  Solved s{std::move(start), {}};
  s.end = solver.solve(bodies, contacts, {tolerance, INFINITY, 200000, parts}, s.impulse, team);
  CHECK(s.end.residual <= tolerance);
  return s;
}

/// Velocity of a box of 2 x 2 x 1 m after 0.1 s on a slope, by steps of 1 ms (m/s).
double slide_down(double angle, bool parts) {
  const double dt = 1e-3;
  const Vec3 pull = g0 * Vec3(std::sin(angle), 0, -std::cos(angle));
  const std::vector<ConeBody> bodies{box(1, {2, 2, 1})};
  std::vector<ConeContact> contacts;
  for (const double x : {-1, 1})
    for (const double y : {-1, 1}) contacts.push_back(on_ground(0, {x, y, -0.5}, 0.5));
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
  double gap = 0;
  Team team(1);
  ConeSolver solver;
  std::vector<ConeRows> impulse(4, ConeRows{});
  for (int step = 0; step < 100; ++step) {
    velocity += dt * pull;
    for (ConeContact& c : contacts) {
      const Vec3 v = -velocity - spin.cross(c.arm_a);
      c.free = {c.normal.dot(v) + gap / dt, c.across.dot(v), c.normal.cross(c.across).dot(v)};
    }
    solver.solve(bodies, contacts, {1e-12, INFINITY, 20000, parts}, impulse, team);
    const auto& change = solver.changes(bodies, contacts, impulse, team);
    velocity += change[0].velocity, spin += change[0].spin;
    gap += dt * velocity.z();
  }
  return velocity.x();
}

/// The contacts of ten spheres, one on the other, in a step of `dt` (s) of their fall.
std::vector<ConeContact> stack(double radius, double dt) {
  std::vector<ConeContact> contacts{on_ground(0, {0, 0, -radius}, 0.5)};
  contacts[0].free[press_row] = -dt * g0;
  for (Index i = 1; i < 10; ++i)
    contacts.push_back({.a = i - 1,
                        .b = i,
                        .normal = Vec3::UnitZ(),
                        .across = Vec3::UnitX(),
                        .arm_a = {0, 0, radius},
                        .arm_b = {0, 0, -radius},
                        .friction = 0.5});
  return contacts;
}

}  // namespace

TEST_CASE("a block on a slope sticks below the angle of friction and slides above it as Coulomb says") {
  const double degree = pi / 180, exact = g0 * (std::sin(30 * degree) - 0.5 * std::cos(30 * degree));
  CHECK(std::abs(slide_down(20 * degree, false)) < 1e-9);
  CHECK(slide_down(30 * degree, false) == Approx(0.1 * exact).epsilon(1e-4));
  // As the minimum has it, what slides parts by friction x slip: less presses, from the second step on.
  CHECK(slide_down(30 * degree, true) < (1 - 1e-3) * 0.1 * exact);
}

TEST_CASE("a stack of ten spheres carries its weight") {
  const double radius = 1e-3, mass = 2650 * 4 * pi / 3 * radius * radius * radius, dt = 1e-4;
  const std::vector<ConeBody> bodies(10, sphere(mass, radius));
  const auto impulse = solve(bodies, stack(radius, dt)).impulse;
  for (std::size_t i = 0; i < 10; ++i)
    CHECK(impulse[i][press_row] / dt == Approx(static_cast<double>(10 - i) * mass * g0).epsilon(1e-6));
  CHECK(impulse[0][press_row] / dt == Approx(1.088939e-3).epsilon(1e-6));
}

TEST_CASE("more is sought for than is asked in the first iterations, and no longer") {
  const std::vector<ConeBody> bodies(10, sphere(1, 1));
  Team team(1);
  const auto end = [&](ConeSettings asked) {
    std::vector<ConeRows> impulse(10, ConeRows{});
    asked.tolerance = 1e-3, asked.by_overlap = INFINITY;
    return ConeSolver().solve(bodies, stack(1, 0.01), asked, impulse, team);
  };
  const ConeEnd plain = end({.wish = 1}), fine = end({.wish = 1e-6});
  CHECK(plain.residual <= 1e-3);
  CHECK(plain.residual > 1e-9);
  CHECK(fine.residual <= 1e-9);
  REQUIRE(fine.iterations > plain.iterations + 20);
  const ConeEnd soon = end({.wish = 1e-6, .wished = plain.iterations + 20});
  CHECK(soon.iterations == plain.iterations + 20);
  CHECK(soon.residual <= 1e-3);
}

TEST_CASE("a body that hits its equal head-on loses what its restitution says") {
  for (const double restitution : {0.0, 0.5}) {
    const ConeContact hit{.a = 0,
                          .b = 1,
                          .normal = Vec3::UnitX(),
                          .across = Vec3::UnitY(),
                          .arm_a = Vec3::UnitX(),
                          .arm_b = -Vec3::UnitX(),
                          .free = {-(1 + restitution)}};
    const double impulse = solve({sphere(1, 1), sphere(1, 1)}, {hit}, false, 1e-13).impulse[0][press_row];
    const double before = 0.5, after = 0.5 * ((1 - impulse) * (1 - impulse) + impulse * impulse);
    CHECK((before - after) / before == Approx(0.5 * (1 - restitution * restitution)).epsilon(1e-9));
  }
}

TEST_CASE("a pressed spring throws its body as implicit Euler says") {
  const double mass = 1, stiffness = 1e5, overlap = 1e-3, dt = 2e-3;
  ConeContact c = on_ground(0, {0, 0, -0.5}, 0.5);
  c.compliance = {1 / (stiffness * dt * dt), 1, 1};
  c.free[press_row] = -overlap / dt;
  const double velocity = solve({box(mass, {1, 1, 1})}, {c}).impulse[0][press_row] / mass;
  CHECK(velocity == Approx(0.142857142857).epsilon(1e-9));
}

TEST_CASE("a bar on three springs: one answer from any start; rigid feet settle sums alone") {
  // The statics of a rigid beam on equal springs; inertia has a share of mass / (3 stiffness dt^2) = 6e-6.
  const double dt = 1e-2, load = 3, at = 4e-3, stiffness = 1e6;
  const std::vector<ConeBody> bodies{box(2650 * 40e-3 * 16e-6, {40e-3, 4e-3, 4e-3})};
  const double fall = dt * load * bodies[0].inverse_mass, turn = dt * load * at * bodies[0].inverse_inertia(1, 1);
  const auto forces = [&](double compliance, double start) {
    std::vector<ConeContact> contacts;
    for (const double x : {-10e-3, 0.0, 10e-3}) {
      contacts.push_back(on_ground(0, {x, 0, -2e-3}, 0));
      contacts.back().free = {-(fall + turn * x)};  // without any contact
      contacts.back().compliance.fill(compliance);
    }
    const auto impulse = solve(bodies, contacts, false, 1e-11, {ConeRows{start}, ConeRows{}, ConeRows{}}).impulse;
    return Vec3(impulse[0][press_row], impulse[1][press_row], impulse[2][press_row]) / dt;
  };
  const double soft = 1 / (stiffness * dt * dt);
  CHECK((forces(soft, 0) - Vec3(0.4, 1, 1.6)).norm() < 1e-4);
  CHECK((forces(soft, 0) - forces(soft, 3e-2)).norm() < 1e-6);
  const Vec3 rigid = forces(0, 0), other = forces(0, 3e-2);
  for (const Vec3& f : {rigid, other}) {
    CHECK(f.sum() == Approx(load).epsilon(1e-6));
    CHECK(10e-3 * (f[2] - f[0]) == Approx(load * at).epsilon(1e-6));
  }
  CHECK((rigid - other).norm() > 0.1);
}

TEST_CASE("the first step of a contact that is alone goes nearly all the way: its length is that of the largest mode") {
  ConeContact c = on_ground(0, {0, 0, -0.5}, 0);
  c.free = {-1, 0, 0};
  const Solved s = solve({box(2, {1, 1, 1})}, {c});  // 1/21 is left by each step
  CHECK(s.impulse[0][press_row] == Approx(2).epsilon(1e-9));
  CHECK(s.end.iterations <= 10);
}

TEST_CASE("what parts presses nothing, with friction and without") {
  for (const double friction : {0.0, 0.5}) {
    ConeContact c = on_ground(0, {0, 0, -0.5}, friction);
    c.free = {1, 0, 0};  // no slip at all
    const Solved s = solve({box(2, {1, 1, 1})}, {c}, false, 1e-10, {ConeRows{3, 0, 0}});
    CHECK(s.impulse[0] == ConeRows{});
  }
}

TEST_CASE("what a solver has solved before changes no bit") {
  std::vector<ConeContact> contacts;
  for (const double x : {-1, 1})
    for (const double y : {-1, 1}) contacts.push_back(on_ground(0, {x, y, -0.5}, 0.5));
  for (ConeContact& c : contacts) c.free = {-1, 0.3, 0.1}, c.slip = 0.2;
  std::vector<ConeContact> others = contacts;
  for (ConeContact& c : others) c.free = {-2, 3, 1}, c.slip = 3;
  const std::vector<ConeBody> bodies{box(1, {2, 2, 1})};
  Team team(1);
  ConeSolver used, fresh;
  std::vector<ConeRows> impulse(4, ConeRows{}), again = impulse, first = impulse;
  const ConeSettings settings{1e-6, INFINITY, 2000, false};
  used.solve(bodies, others, settings, first, team);
  used.solve(bodies, contacts, settings, again, team);
  fresh.solve(bodies, contacts, settings, impulse, team);
  CHECK(again == impulse);
}
