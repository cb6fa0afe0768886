// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls at their limits: many corners, slivers, vertex on vertex, tall stacks, born in each other, all bonds gone at
// once.
#include "dem/contact/forces.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "tests/bonded.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

struct Books {
  double energy = 0;
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
};

Books books_of(const Model& model, const State& s) {
  Books b{stored_energy(model, s)};
  for (std::size_t i = 0; i < s.grains.size(); ++i) {
    const Vec3 p = s.grains.mass[i] * s.grains.motion[i].velocity;
    b.momentum += p, b.angular += s.grains.motion[i].position.cross(p) + s.grains.angular_momentum[i];
  }
  return b;
}

/// Two bodies meet at a speed of 20, in steps of a time (s). What is out of the books; of the energy relative to what
/// was there.
Books collide(const Polyhedron& one, const Polyhedron& other, const Vec3& towards, const Quat& turn, double step) {
  Model model = hull_model();
  model.numerics.time_step = step;
  State s;
  add_body(s, one, Vec3::Zero(), Quat::Identity());
  add_body(s, other, towards, turn, -20 * towards.normalized(), Vec3(1, -2, 1.5));
  Team team(1);
  prepare(model, s, team);
  const Books before = books_of(model, s);
  double most = 0, now = 0;
  for (int k = 0; k < 20000 && !(most > 0 && now == 0); ++k) {
    run_steps(model, s, 10, team);
    now = elastic_energy(model.law, s.contacts), most = std::max(most, now);
  }
  CHECK(most > 0.005 * before.energy);
  CHECK(now == 0);  // apart again
  const Books after = books_of(model, s);
  return {after.energy / before.energy - 1, after.momentum - before.momentum, after.angular - before.angular};
}

Polyhedron rod(int corners, double radius, double length) {
  std::vector<Vec3> ring;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * pi * k / corners;
    ring.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return prism_over(ring, -0.5 * length, 0.5 * length);
}

}  // namespace

TEST_CASE("collisions of bodies at the limits keep energy, momentum and angular momentum") {
  const Quat diagonal = Quat::FromTwoVectors(Vec3(1, 1, 1).normalized(), Vec3::UnitZ());
  const Vec3 skew = Vec3(1, 0.3, 0.2).normalized();
  const Polyhedron coin = rod(32, 0.5, 0.4), sliver = box_between(Vec3(-0.5, -0.5, -0.01), Vec3(0.5, 0.5, 0.01));
  const auto checked = [](const Books& off, double energy) {
    CHECK(std::abs(off.energy) < energy);
    CHECK(off.momentum.norm() < 1e-11);
    CHECK(off.angular.norm() < 1e-8);
  };
  // Half period of a unit mass on c A: 2.2 ms; of the coins a fifth of it in mass.
  checked(collide(coin, coin, 1.2 * skew, Quat(0.9, 0.1, 0.3, 0.3).normalized(), 5e-6), 1e-7);
  // Corner on corner along the diagonals of both: kinks of the shallowest planes meet in one line.
  const Polyhedron corner_up = [&] {
    Polyhedron p = unit_cube();
    place(p, diagonal.toRotationMatrix(), Vec3::Zero());
    return p;
  }();
  checked(collide(corner_up, corner_up, Vec3(0, 0, 1.75), Quat(0, 1, 0, 0), 5e-6), 1e-7);
  // A plate of a fiftieth: mass 0.02, and overlaps of the order of its thickness.
  checked(collide(sliver, unit_cube(), 1.2 * skew, Quat(0.8, 0.2, 0.4, 0.3).normalized(), 1e-6), 2e-6);
}

TEST_CASE("a stack of fifty cubes stands as deep in each other as their weight has it") {
  Model model = hull_model(0.5, 1e6);
  model.materials[0].damping = 0.3;
  make_pair_laws(model);
  set_damping(model, 0.3);
  model.motion.gravity = Vec3(0, 0, -1);
  State s;
  constexpr int n = 50;
  double top = 0;
  for (int k = 0; k < n; ++k) {  // below cube k: the weight of n - k over c A; the floor has the same modulus
    top += 1 - (n - k) / 1e6;
    add_body(s, unit_cube(), Vec3(0, 0, top - 0.5), Quat::Identity());
  }
  add_floor(s);
  Team team(1);
  prepare(model, s, team);
  run_steps(model, s, 4000, team);
  double highest = 0, aside = 0;
  for (const Motion& m : s.grains.motion)
    highest = std::max(highest, m.position.z()), aside = std::max(aside, m.position.head<2>().norm());
  CHECK(highest == Approx(top - 0.5).margin(1e-8));
  CHECK(aside < 1e-8);
  CHECK(kinetic_energy(s.grains) < 1e-12);
}

TEST_CASE("hulls born in each other fly apart with the energy of their overlap") {
  Model model = hull_model();
  model.numerics.time_step = 1e-6;
  model.numerics.max_overlap = 1;
  State s;
  add_body(s, unit_cube(), Vec3::Zero(), Quat::Identity());
  add_body(s, unit_cube(), Vec3(0.7, 0, 0), Quat::Identity());
  Team team(1);
  prepare(model, s, team);
  const double held = 0.5 * modulus * 0.3 * 0.3;
  CHECK(stored_energy(model, s) == Approx(held).epsilon(1e-9));
  run_steps(model, s, 4000, team);
  CHECK(elastic_energy(model.law, s.contacts) == 0);
  CHECK(kinetic_energy(s.grains) == Approx(held).epsilon(1e-5));
  CHECK((s.grains.motion[0].velocity + s.grains.motion[1].velocity).norm() < 1e-12 * std::sqrt(held));
}

TEST_CASE("all bonds broken in one step: energy and momentum stay in the books, and every pair that presses touches") {
  Team team(2);
  BondModel bond = elastic(0.5);
  bond.criterion = FaceCriterion::strain_sum, bond.tension = 1e-9, bond.cohesion = 1e-9, bond.friction = 0.4;
  Model model = rock(bond, 0.4);
  model.numerics.safety = 0.1;
  State s;
  add_voronoi_grains(model, voronoi_packing(box_space(Vec3(5, 5, 5)), 125, 5, 1, team), 0, s);
  for (std::size_t i = 0; i < s.grains.size(); ++i)
    for (int k = 0; k < 3; ++k)
      s.grains.motion[i].velocity[k] = random_normal(8, i, Purpose::turn, static_cast<std::uint64_t>(k));
  prepare(model, s, team);
  const std::size_t all = s.bonds.size();
  const Books before = books_of(model, s);
  run_steps(model, s, 2, team);
  CHECK(s.bonds.empty());
  CHECK(s.ledger.bonds_broken == all);
  run_steps(model, s, 400, team);
  const Books after = books_of(model, s);
  CHECK((after.momentum - before.momentum).norm() < 1e-9 * before.energy);
  CHECK((after.angular - before.angular).norm() < 1e-6 * before.energy);
  CHECK(std::abs(energy_error(s.ledger, after.energy)) < 0.01);
  CHECK(s.contacts.size() > all / 2);
}
