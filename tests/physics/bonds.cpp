// SPDX-License-Identifier: LGPL-3.0-or-later
// Bonds of any number and place: same bits for any number of threads, images, and what they add to stress and tangents.
#include <cstring>

#include "dem/bond/cohesive.hpp"
#include "dem/motion/critical_step.hpp"
#include "dem/rve/linear_response.hpp"
#include "dem/rve/measure.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 3e-4;

/// Simple cubic, periodic; grain x + n (y + n z).
State cubic(int n, double overlap) {
  State s;
  const double d = 2 * R - overlap;
  for (int i = 0; i < n * n * n; ++i) add(s, PolyEllipsoid::sphere(R), d * Vec3(i % n, i / n % n, i / (n * n)), 2650);
  s.boundary.cell.vectors = n * d * Mat3::Identity();
  return s;
}

/// Between the grains' surfaces along `way`; `image` cell vectors are added to b.
CohesiveSpring spring_between(Index a, Index b, const Vec3& way, std::array<std::int16_t, 3> image = {}) {
  CohesiveSpring s;
  s.ends = {a, b, image};
  s.at_a = R * way, s.at_b = -R * way, s.normal_a = way, s.preload = 1e-3 * R * way;
  s.peak = 1, s.onset = 1e-2 * R, s.rupture = 2e-2 * R, s.reached = s.onset;
  return s;
}

/// 1,000 grains with random springs between near and far ones, some broken at the first look, none at rest.
State crowded() {
  State s = cubic(10, -1e-2 * R);
  for (std::size_t i = 0; i < s.grains.size(); ++i) {
    s.grains.motion[i].position += 4e-3 * R * (random_rotation(3, i) * Vec3(1, 0, 0));
    s.grains.orientation[i] = Quat::Identity().slerp(1e-4, random_rotation(4, i));
  }
  for (std::uint64_t k = 0; k < 3000; ++k) {
    const auto i = static_cast<Index>(997 * k % 990);
    const auto to = static_cast<Index>(k % 3 == 0 ? i + 1 : (i + 1 + 31 * k) % 1000);
    if (to == i) continue;
    const Vec3 way = s.grains.motion[to].position - s.grains.motion[i].position;
    CohesiveSpring spring = spring_between(k % 2 ? i : to, k % 2 ? to : i, (k % 2 ? 1 : -1) * way.normalized());
    // Of a length of its own: it opens by some part of its onset.
    spring.preload -= (1 - 2 * R / way.norm()) * (k % 2 ? 1 : -1) * way;
    if (k % 50 == 0) spring.rupture = 1.0001 * spring.onset, spring.preload += 0.05 * R * spring.normal_a;
    s.bonds.cohesive.row.push_back(spring);
  }
  return s;
}

}  // namespace

TEST_CASE("bonds give the same bits for any number of threads, those of one after the other, and no momentum") {
  State one = crowded();
  const std::size_t grains = one.grains.size();
  REQUIRE(tile_count(grains) > 4);
  Team alone(1);
  // One after the other, by the law alone.
  std::vector<CohesiveSpring> rows = one.bonds.cohesive.row;
  std::vector<Vec3> force(grains, Vec3::Zero()), torque = force;
  double spent = 0, size = 0;
  std::size_t gone = 0;
  for (CohesiveSpring& row : rows) {
    const double before = dissipated(row);
    const Pull p = pull(row, frame_of(one.grains, one.boundary.cell, row.ends), {});
    spent += dissipated(row) - before, gone += broken(row), size += p.force.norm();
    force[row.ends.a] -= p.force, torque[row.ends.a] -= p.arm_a.cross(p.force);
    force[row.ends.b] += p.force, torque[row.ends.b] += p.arm_b.cross(p.force);
  }
  REQUIRE(gone > 10);
  REQUIRE(gone < rows.size() / 2);
  REQUIRE(spent > 0);
  State many = one;
  for (std::size_t i = 0; i < grains; ++i) one.grains.force[i] = many.grains.force[i] = Vec3(1, 2, 3);  // to be cleared
  bond_forces(one.grains, one.boundary.cell, one.bonds, one.ledger, alone);
  CHECK(one.ledger.bonds_broken == gone);
  CHECK(one.bonds.size() == rows.size() - gone);
  CHECK(one.ledger.fracture == Approx(spent).epsilon(1e-12));
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  for (std::size_t i = 0; i < grains; ++i) {
    REQUIRE((one.grains.force[i] - force[i]).norm() < 1e-12 * size);
    REQUIRE((one.grains.torque[i] - torque[i]).norm() < 1e-12 * size * R);
    sum += one.grains.force[i];
    moment += one.grains.torque[i] + one.grains.motion[i].position.cross(one.grains.force[i]);
  }
  CHECK(sum.norm() < 1e-13 * size);
  CHECK(moment.norm() < 1e-12 * size * 20 * R);
  const auto same = [](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
  };
  for (const int threads : {2, 3}) {
    State s = many;
    Team team(threads);
    bond_forces(s.grains, s.boundary.cell, s.bonds, s.ledger, team);
    CHECK(same(s.grains.force, one.grains.force));
    CHECK(same(s.grains.torque, one.grains.torque));
    CHECK(s.ledger.fracture == one.ledger.fracture);
  }
  // Again: only what bonds have written is cleared, and dealt anew, since some have gone.
  State again = one;
  bond_forces(again.grains, again.boundary.cell, again.bonds, again.ledger, alone, true);
  State fresh = one;
  bond_forces(fresh.grains, fresh.boundary.cell, fresh.bonds, fresh.ledger, alone);
  std::vector<std::uint8_t> held(grains, 0);
  for_each_bond(fresh.bonds, [&](const auto& b) { held[b.ends.a] = held[b.ends.b] = 1; });
  for (std::size_t i = 0; i < grains; ++i)
    if (held[i]) REQUIRE(again.grains.force[i] == fresh.grains.force[i]);
}

TEST_CASE("what a bond gives back is not made good by what others take") {
  State s = cubic(2, -1e-2 * R);  // one tile
  const Vec3 way(1, 0, 0);
  s.bonds.cohesive.row = {spring_between(0, 1, way), spring_between(2, 3, way)};
  for (CohesiveSpring& spring : s.bonds.cohesive.row) spring.preload.setZero();
  const auto go_on = [&](double opening) {
    s.grains.motion[1].position.x() += opening, s.grains.motion[3].position.x() += opening;
    Team team(1);
    bond_forces(s.grains, s.boundary.cell, s.bonds, s.ledger, team);
  };
  go_on(2e-3 * R);
  const double each = 0.5 * s.ledger.fracture;
  CHECK(each == Approx(0.5 * 2e-2 * R * 0.2));
  CHECK(s.ledger.most_fracture == s.ledger.fracture);
  s.bonds.cohesive.row[1].peak *= -2;  // of this one softening gives
  go_on(2e-3 * R);
  CHECK(s.ledger.fracture == Approx(each));
  s.bonds.cohesive.row[1].peak *= -0.25;
  go_on(2e-3 * R);
  CHECK(s.ledger.fracture == Approx(2.5 * each));
  CHECK(s.ledger.most_fracture - s.ledger.fracture == Approx(each));
}

TEST_CASE("a bond across the cell's border is the bond to the grain where it is seen") {
  Model model = model_of(solid(60e9, 0.17, 2650));
  State s;
  const double L = 10 * R;
  add(s, PolyEllipsoid::sphere(R), Vec3(0.5 * R, 0, 0), 2650);
  add(s, PolyEllipsoid::sphere(R), Vec3(L - 1.505 * R, 0.002 * R, 0), 2650);
  s.boundary.cell.vectors = L * Mat3::Identity();
  State seen = s;
  seen.grains.motion[1].position.x() -= L;
  s.bonds.cohesive.row.push_back(spring_between(0, 1, Vec3(-1, 0, 0), {-1, 0, 0}));
  seen.bonds.cohesive.row.push_back(spring_between(0, 1, Vec3(-1, 0, 0)));
  Team team(1);
  for (State* state : {&s, &seen}) {
    prepare(model, *state, team);
    bond_forces(state->grains, state->boundary.cell, state->bonds, state->ledger, team);
  }
  REQUIRE(seen.grains.force[0].norm() > 0.1);
  for (const std::size_t i : {0u, 1u}) {
    CHECK((s.grains.force[i] - seen.grains.force[i]).norm() < 1e-9 * seen.grains.force[i].norm());
    CHECK((s.grains.torque[i] - seen.grains.torque[i]).norm() < 1e-9 * seen.grains.force[i].norm() * R);
  }
  const Mat3 stress = love_weber(s, L * L * L);
  CHECK((stress - love_weber(seen, L * L * L)).norm() < 1e-9 * stress.norm());
  CHECK(stress(0, 0) == Approx(-s.bonds.cohesive.row[0].force.x() * -2.005 * R / (L * L * L)).epsilon(1e-12));
}

TEST_CASE("bonds along one axis stiffen a lattice by their stiffness over its spacing, and only there") {
  const Model model = model_of(solid(60e9, 0.17, 2650));
  State s = cubic(3, 2e-3 * R);
  Team team(1);
  prepare(model, s, team);
  const double spacing = 2 * R - 2e-3 * R;
  const Mat6 network = network_tangent(model, s), contacts = contact_stiffness_tangent(model, s);
  for (Index i = 0; i < 27; ++i) {
    const bool last = i / 9 == 2;
    s.bonds.cohesive.row.push_back(
        spring_between(i, last ? i - 18 : i + 9, Vec3(0, 0, 1), {0, 0, static_cast<std::int16_t>(last)}));
  }
  const double k = secant(s.bonds.cohesive.row[0]);
  REQUIRE(k == Approx(1 / (1e-2 * R)));
  for (const Mat6& more :
       {Mat6(network_tangent(model, s) - network), Mat6(contact_stiffness_tangent(model, s) - contacts)}) {
    CHECK(more(2, 2) == Approx(k / spacing).epsilon(1e-6));
    CHECK(std::abs(more(0, 0)) + std::abs(more(1, 1)) + std::abs(more(0, 1)) < 1e-6 * k / spacing);
  }
  CHECK(linear_response(model, s, 0.5) == nullptr);  // springs soften: no elastic range
  // All of them may set the time step.
  const auto step = [&] {
    return critical_step(model.law, model.pairs, 2, s.grains, s.boundary, s.contacts, s.bonds).dt;
  };
  const double bonded = step();
  for (auto& row : s.bonds.cohesive.row) row.peak *= 1e8;
  const double stiff = step();
  for (auto& row : s.bonds.cohesive.row) row.peak *= 100;
  CHECK(stiff < 0.1 * bonded);
  CHECK(step() == Approx(0.1 * stiff).epsilon(1e-3));
}
