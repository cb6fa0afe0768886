// SPDX-License-Identifier: LGPL-3.0-or-later
// Steps of hulls that do not give way, against closed forms of rigid bodies; and what they leave open.
#include "dem/rve/measure.hpp"
#include "dem/rve/rigid_stepper.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/state/order.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double g0 = 9.81, degree = pi / 180;

/// `slope` (rad): of the floor, down which x goes.
Model rigid(double friction, double step = 0, double slope = 0) {
  Model model = hull_model(friction, 1e9, 0);
  model.stepper = &rigid_stepper, model.numerics.time_step = step;
  model.motion.gravity = g0 * Vec3(std::sin(slope), 0, -std::cos(slope));
  return model;
}

/// By steps of the stepper's own choice.
void run_to(const Model& model, State& s, double time, Team& team) {
  while (s.time < time) {
    update_time_step(model, s);
    run_steps(model, s, 1, team);
  }
}

double error_of(const Model& model, const State& s) { return energy_error(s.ledger, stored_energy(model, s)); }

Polyhedron block(const Vec3& sides) { return box_between(-0.5 * sides, 0.5 * sides); }

/// On a floor, as deep as contacts keep.
State on_floor(const Vec3& sides) {
  State s;
  const double radius = std::cbrt(sides.prod() / (4 * pi / 3));
  add_body(s, block(sides), Vec3(0, 0, 0.5 * sides.z() - 1e-4 * radius), Quat::Identity());
  add_floor(s);
  return s;
}

Vec3 force_on_floor(const State& s) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = s.contacts.begin[first_wall]; k < s.contacts.size(); ++k)
    if (s.contacts.contact.touching(k)) sum += s.contacts.touch[k].force;
  return sum;
}

}  // namespace

TEST_CASE("a block rests on a plane: its corners bear its weight, and it stays where it is") {
  Team team(1);
  const Model model = rigid(0.5);
  State s = on_floor(Vec3(2, 1, 1));
  prepare(model, s, team);
  const Vec3 before = s.grains.motion[0].position;
  run_to(model, s, 1, team);
  CHECK((force_on_floor(s) - Vec3(0, 0, -2 * g0)).norm() < 1e-4 * 2 * g0);
  CHECK((s.grains.motion[0].position - before).norm() < 1e-6);
  CHECK(s.grains.motion[0].spin.norm() < 1e-5);
  CHECK(s.steps < 100);
}

TEST_CASE("a block on a slope sticks up to its angle of friction, and slides above it as Coulomb says") {
  Team team(1);
  const double mu = 0.5, edge = std::atan(mu), duration = 0.1;
  for (const double angle : {20 * degree, edge - 1e-3, edge + 1e-3, 30 * degree}) {
    const Model model = rigid(mu, 1e-3, angle);
    State s = on_floor(Vec3(2, 2, 1));
    prepare(model, s, team);
    run_for(model, s, duration, team);
    const double exact = std::max(0.0, g0 * (std::sin(angle) - mu * std::cos(angle)) * duration);
    const Motion& m = s.grains.motion[0];
    CHECK(m.velocity.x() == Approx(exact).epsilon(1e-3).margin(1e-5));
    if (angle > 29 * degree) CHECK(m.velocity.x() == Approx(0.0657145).epsilon(1e-3));
    CHECK(std::abs(error_of(model, s)) < 1e-9);
    // Sliding, friction has the work of Coulomb's force; implicit Euler goes half a step further.
    if (exact > 0) CHECK(s.ledger.friction == Approx(mu * 4 * g0 * std::cos(angle) * m.position.x()).epsilon(2e-3));
    CHECK(std::abs(m.velocity.z()) < 1e-5);  // it does not part as the minimum would have it
  }
}

TEST_CASE("ten blocks one on the other: each bears what is above it") {
  Team team(1);
  const Model model = rigid(0.5);
  State s;
  const double kept = 1e-4 * std::cbrt(1 / (4 * pi / 3));
  for (int i = 0; i < 10; ++i)
    add_body(s, unit_cube(), Vec3(0, 0, 0.5 + i - kept * (i + 1)), Quat(Eigen::AngleAxisd(0.3 * i, Vec3::UnitZ())));
  add_floor(s);
  prepare(model, s, team);
  run_to(model, s, 1, team);
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    if (!s.contacts.contact.touching(k)) continue;
    const bool walled = k >= s.contacts.begin[first_wall];
    const double above = walled ? 10 : 10 - static_cast<double>(s.contacts.pair[k].b);
    CHECK(s.contacts.touch[k].force.norm() == Approx(above * g0).epsilon(1e-3));
  }
  for (const Motion& m : s.grains.motion) CHECK(m.velocity.norm() < 1e-4);
}

TEST_CASE("a blow without rebound takes the energy that statics of impulses says") {
  Team team(1);
  Model model = rigid(0);
  model.motion.gravity.setZero();
  SECTION("face to face, head-on and shifted: by what both give at the middle of the shared face") {
    for (const Vec3& off : {Vec3(0, 0, 0), Vec3(0, 0.2, 0.1)}) {
      State s;
      add_body(s, unit_cube(), Vec3(0, 0, 0), Quat::Identity(), Vec3(1, 0, 0));
      add_body(s, unit_cube(), Vec3(1.05, 0, 0) + off, Quat::Identity());
      prepare(model, s, team);
      run_to(model, s, 0.08, team);
      const double lever2 = 0.25 * off.squaredNorm(), lost = 0.5 / (2 * (1 + 6 * lever2));  // I = m / 6
      CHECK(0.5 - kinetic_energy(s.grains) == Approx(lost).epsilon(1e-3));
      CHECK(s.ledger.damping == Approx(lost).epsilon(1e-3));
      CHECK(std::abs(error_of(model, s)) < 1e-5);
      CHECK((momentum(s.grains) - Vec3(1, 0, 0)).norm() < 1e-9);
      const double kept = 1e-4 * std::cbrt(1 / (4 * pi / 3)),
                   apart = s.grains.motion[1].position.x() - s.grains.motion[0].position.x();
      CHECK(apart == Approx(1 - kept).margin(off.isZero() ? kept : 5e-3));  // turned a little, they touch by an edge
    }
  }
  SECTION("on a corner: by what it gives there") {
    // m / (1 + (r x n)^2 m / I) meets the floor, r from the mass centre: a cube turned about y.
    model.numerics.time_step = 1e-4;
    const double turned = 0.3, speed = 1;
    State s;
    const Quat q(Eigen::AngleAxisd(turned, Vec3::UnitY()));
    const Vec3 edge = q * Vec3(0.5, 0, -0.5);  // its lowest edge
    add_body(s, unit_cube(), Vec3(0, 0, 0.00305 - edge.z()), q, Vec3(0, 0, -speed));
    add_floor(s);
    prepare(model, s, team);
    run_to(model, s, 0.01, team);
    const double lever = edge.x(), inertia = 1.0 / 6, met = 1 / (1 + lever * lever / inertia);
    CHECK(0.5 * speed * speed - kinetic_energy(s.grains) == Approx(0.5 * met * speed * speed).epsilon(1e-3));
    CHECK(std::abs(error_of(model, s)) < 1e-6);
    CHECK(std::abs(s.grains.motion[0].spin.y()) == Approx(met * speed * std::abs(lever) / inertia).epsilon(1e-3));
  }
}

TEST_CASE("a tall block stands up to the angle at which its weight leaves its foot, and falls over beyond it") {
  Team team(1);
  const double width = 1, height = 3, exact = std::atan(width / height);
  for (const double off : {-0.002, 0.002}) {
    const double angle = exact + off, duration = 0.5;
    const Model model = rigid(1, 2e-3, angle);
    State s = on_floor(Vec3(width, width, height));
    prepare(model, s, team);
    run_for(model, s, duration, team);
    // About its lower edge: g (h/2 sin - b/2 cos) / (I / m), I / m = (b^2 + h^2) / 3; the lever grows as it turns.
    const double lean = 0.5 * g0 * (height * std::sin(angle) - width * std::cos(angle)),
                 inertia = (width * width + height * height) / 3,
                 rate = std::sqrt(0.5 * g0 * (height * std::cos(angle) + width * std::sin(angle)) / inertia);
    const double spin = off > 0 ? lean / inertia / rate * std::sinh(rate * duration) : 0;
    CHECK(s.grains.motion[0].spin.y() == Approx(spin).epsilon(0.02).margin(1e-4));
    CHECK(std::abs(error_of(model, s)) < 1e-6);
  }
}

TEST_CASE("what is deep in each other is parted, and gets no speed by it") {
  Team team(1);
  const Model model = rigid(0.5, 1e-3);
  const double deep = 0.03, kept = 1e-4 * std::cbrt(1 / (4 * pi / 3));
  State s;
  add_body(s, unit_cube(), Vec3(0, 0, 0.5 - deep), Quat::Identity());
  add_body(s, unit_cube(), Vec3(1 - deep, 0, 0.5 - deep), Quat::Identity());
  add_floor(s);
  prepare(model, s, team);
  double fastest = 0, most = 0;
  for (int step = 0; step < 40; ++step) {
    run_steps(model, s, 1, team);
    fastest = std::max(fastest, s.grains.motion[0].velocity.norm() + s.grains.motion[1].velocity.norm());
    most = std::max(most, std::abs(error_of(model, s)));
  }
  const Motion &a = s.grains.motion[0], &b = s.grains.motion[1];
  CHECK(a.position.z() == Approx(0.5 - kept).margin(kept));
  CHECK(b.position.z() == Approx(0.5 - kept).margin(kept));
  CHECK(b.position.x() - a.position.x() == Approx(1 - kept).margin(kept));
  CHECK(a.position.x() + b.position.x() == Approx(1 - deep).margin(kept));  // about their middle
  CHECK(fastest < 4 * g0 * 1e-3);  // a fall of a step or two; thrown out in one it would be 30 m/s
  CHECK(most < 1e-6);
  CHECK(s.ledger.work == Approx(-g0 * (a.position.z() + b.position.z() - 1 + 2 * deep)).epsilon(1e-3));
  CHECK(force_on_floor(s).z() == Approx(-2 * g0).epsilon(1e-3));
}

namespace {

/// Angular grains in a box, under a lid of many times their weight; they have come to rest on their own springs.
struct Heap {
  Model model;
  State state;
};

Heap heap_under_lid(Team& team) {
  Heap h{hull_model(0.5, 1e6, 0.1), {}};
  h.model.motion.gravity = -g0 * Vec3::UnitZ();
  const double size = 4;
  add_box(h.state, size);
  h.state.boundary.walls.pop_back();  // no roof
  const Tessellation cells = voronoi_packing(periodic_space(Vec3::Constant(2.6)), 64, 2, 3, team);
  for (std::size_t i = 0; i < cells.body.size(); ++i) {
    Polyhedron body = cells.body[i];
    const Vec3 centre = moments_of(body).centre;
    const double around = 0.5 * size / 4;
    place(body, Mat3::Identity(), -centre);
    const auto at = [&](std::size_t n) { return (2 * static_cast<double>(n) + 1) * around; };
    add_body(h.state, body, Vec3(at(i % 4), at(i / 4 % 4), at(i / 16) + 0.1), Quat::Identity());
  }
  add_body(h.state, box_between(Vec3(-1.99, -1.99, -10), Vec3(1.99, 1.99, 10)), Vec3(2, 2, 14.2), Quat::Identity());
  Model damped = h.model;
  set_damping(damped, 0.4);
  prepare(damped, h.state, team);
  run_for(damped, h.state, 3, team);
  return h;
}

/// Largest force of each grain.
std::vector<double> largest_forces(const State& s) {
  std::vector<double> largest(s.grains.size());
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    if (!s.contacts.contact.touching(k)) continue;
    const Pair& p = s.contacts.pair[k];
    const double force = s.contacts.touch[k].force.norm();
    largest[p.a] = std::max(largest[p.a], force);
    if (k < s.contacts.begin[first_wall]) largest[p.b] = std::max(largest[p.b], force);
  }
  return largest;
}

double off(const std::vector<double>& a, const std::vector<double>& b) {
  double d2 = 0, sum2 = 0;
  for (std::size_t i = 0; i < a.size(); ++i) d2 += (a[i] - b[i]) * (a[i] - b[i]), sum2 += b[i] * b[i];
  return std::sqrt(d2 / sum2);
}

}  // namespace

TEST_CASE(
    "a heap under a lid: its ledger closes and its sums are right, who bears what hangs on where the search begins") {
  Team team(1);
  Heap h = heap_under_lid(team);
  double weight = 0;
  for (const double m : h.state.grains.mass) weight += g0 * m;
  CHECK(force_on_floor(h.state).z() == Approx(-weight).epsilon(0.01));
  Model stiff = h.model;
  stiff.stepper = &rigid_stepper, stiff.numerics.max_time_step = 5e-3;
  State rest = h.state;
  rest.ledger = {};
  prepare(stiff, rest, team);
  run_to(stiff, rest, rest.time + 1, team);
  CHECK(std::abs(error_of(stiff, rest)) < 1e-9);
  CHECK(kinetic_energy(rest.grains) < 1e-4 * weight);
  CHECK(h.state.grains.motion.back().position.z() == Approx(rest.grains.motion.back().position.z()).margin(2e-3));
  std::vector<std::vector<double>> found;
  const auto begun = [&](auto&& share) {
    State s = rest;
    for (std::size_t k = 0; k < s.contacts.size(); ++k) s.contacts.touch[k].force *= share(k);
    run_steps(stiff, s, 1, team);
    CHECK(force_on_floor(s).z() == Approx(-weight).epsilon(0.02));
    return largest_forces(s);
  };
  const auto drawn = [](std::uint64_t draw) {
    return [=](std::size_t k) { return 2 * random_uniform(7, k, Purpose::position, draw); };
  };
  const auto usual = begun([](std::size_t) { return 1; }), none = begun([](std::size_t) { return 0; });
  const double without = off(none, usual), one = off(begun(drawn(1)), usual), two = off(begun(drawn(2)), usual);
  WARN("largest forces from nothing, and from random shares: "
       << without << " " << one << " " << two << " off; from springs' " << off(usual, largest_forces(h.state)));
  for (const double by : {without, one, two}) CHECK((by > 0.02 && by < 0.6));

  // In another order of the grains, and so of the rows, it is the same answer from the same start.
  State turned = rest;
  std::vector<Index> order(rest.grains.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(order.size() - 1 - i);
  reorder(turned.grains, order);
  turned.contacts = {}, turned.reference = {};
  prepare(stiff, turned, team);
  turned.dt = rest.dt;
  for (Touch& touch : turned.contacts.touch) touch.force.setZero();
  run_steps(stiff, turned, 1, team);
  std::vector<double> back = largest_forces(turned);
  std::reverse(back.begin(), back.end());
  CHECK(off(back, none) < 0.01);

  State three = rest, one_thread = rest;
  Team threads(3);
  run_steps(stiff, three, 5, threads), run_steps(stiff, one_thread, 5, team);
  CHECK(hash(three) == hash(one_thread));
}
