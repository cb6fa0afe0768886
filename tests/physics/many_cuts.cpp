// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls that are cut many times: what is kept, planes that have no room, rows of hulls that are gone.
#include "dem/packing/random_hulls.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/state/order.hpp"
#include "tests/cleaving_cells.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// Second moments of mass about the origin, of all solids (kg m^2).
Mat3 second_moments(const Grains& g) {
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = 0; i < g.size(); ++i) {
    const Mat3 axes = (g.orientation[i] * g.inertia[i].axes).toRotationMatrix();
    const Vec3 moments = g.inertia[i].moments, x = g.motion[i].position;
    sum += axes * (0.5 * moments.sum() * Vec3::Ones() - moments).asDiagonal() * axes.transpose() +
           g.mass[i] * x * x.transpose();
  }
  return sum;
}

}  // namespace

TEST_CASE("a grain cut twenty times, all grains at once, and along a face: masses, and no number is lost") {
  Team team(2);
  Model model = cleaving_rock(false);
  model.materials[0].density = 1;
  State s;
  add_body(s, unit_cube(), Vec3::Zero(), Quat::Identity());
  prepare(model, s, team);
  for (std::uint64_t k = 0; k < 20; ++k) {
    const std::size_t i = static_cast<std::size_t>(
        std::max_element(s.grains.extent.begin(), s.grains.extent.end(),
                         [](const Extent& a, const Extent& b) { return a.volume < b.volume; }) -
        s.grains.extent.begin());
    apply_breaks(model, s, {{i, {Mat3::Zero(), random_vector(k, 1).normalized()}}}, team);
  }
  CHECK(s.grains.size() == 21);
  CHECK(std::abs(total_mass(s.grains) - 1) < 1e-12);
  std::vector<Break> all;
  for (std::size_t i = 0; i < 21; ++i) all.push_back({i, {Mat3::Zero(), random_vector(i, 2).normalized()}});
  apply_breaks(model, s, all, team);
  CHECK(s.grains.size() == 42);
  CHECK(std::abs(total_mass(s.grains) - 1) < 1e-12);
  CHECK(std::isfinite(stored_energy(model, s)));
  // In a face, and through a corner alone, there is nothing to cut.
  State cube;
  add_body(cube, unit_cube(), Vec3::Zero(), Quat::Identity());
  const FractureModel& f = *model.materials[0].fracture;
  const auto made = [&](const Vec3& n, double offset) {
    return grus::dem::pieces_of(f.splitter, cube.grains, 0, {Mat3::Zero(), n, Vec3::Zero(), offset}, 1).piece.size();
  };
  CHECK(made(Vec3::UnitX(), 0.5) == 0);
  CHECK(made(Vec3::Ones().normalized(), 0.5 * std::sqrt(3.0)) == 0);
  CHECK(made(Vec3::UnitX(), 0.4) == 2);
  CHECK(made(Vec3(1, 1, 0).normalized(), 0) == 2);  // along edges
}

TEST_CASE("a spinning body cut a thousand times: masses, momenta, second moments; every piece bears the step") {
  Team team(2);
  Model model = cleaving_rock(false);
  model.materials[0].density = 1;
  State s;
  add_body(s, unit_cube(), Vec3::Zero(), Quat::Identity(), Vec3(0.1, -0.2, 0.3), Vec3(0.3, 0.2, -0.1));
  prepare(model, s, team);
  const Vec3 linear = momentum(s.grains), angular = angular_momentum(s.grains);
  const double kinetic = kinetic_energy(s.grains);
  const Mat3 second = second_moments(s.grains);
  const double whole = s.dt;
  // In each round every third is cut, whichever: some pieces are of one cut, others of more than twenty.
  std::uint64_t cuts = 0;
  for (std::uint64_t round = 0; cuts < 1000; ++round) {
    REQUIRE(round < 40);
    std::vector<Break> breaks;
    for (std::size_t i = 0; i < s.grains.size() && cuts + breaks.size() < 1000; ++i)
      if (s.grains.size() < 3 || random_uniform(3, i, Purpose::position, round) < 1.0 / 3)
        breaks.push_back({i, {Mat3::Zero(), random_vector(i, 4 + round).normalized()}});
    const std::size_t before = s.grains.size();
    apply_breaks(model, s, breaks, team);
    cuts += s.grains.size() - before;
  }
  const Fines& f = s.ledger.fines;
  CHECK(s.grains.size() == 1001);
  CHECK(std::abs(total_mass(s.grains) + f.mass - 1) < 1e-11);
  CHECK((momentum(s.grains) + f.momentum - linear).norm() < 1e-11 * linear.norm());
  CHECK((angular_momentum(s.grains) + f.angular_momentum - angular).norm() < 1e-10 * angular.norm());
  CHECK(std::abs(kinetic_energy(s.grains) / kinetic - 1) < 1e-10);
  CHECK((second_moments(s.grains) - second).norm() < 1e-10 * second.norm());
  // The least pieces turn and shift far faster than the whole; with inertia by step nobody is faster than asked.
  prepare(model, s, team);
  CHECK(s.dt < 0.2 * whole);
  model.numerics.inertia_step = 0.5 * whole, s.next_estimate = s.steps;
  update_time_step(model, s);
  CHECK(s.dt > 0.5 * whole * (1 - 1e-9));
  CHECK(total_mass(s.grains) + f.mass == Approx(1).epsilon(1e-11));  // that of the solids
  CHECK(s.ledger.inertia < -0.5 * kinetic);                          // what gets mass keeps its momentum
  CHECK(kinetic_energy(s.grains) == Approx(kinetic + s.ledger.inertia).epsilon(1e-9));
}

TEST_CASE("a ball whose corners come off one by one loses planes, not mass, momentum or the right to break") {
  Team team(1);
  Model model = cleaving_rock(false);
  model.materials[0].density = 1;
  State s;
  const UnitHull ball = ball_of_planes(Vec3::Ones());
  add_body(s, ball.body, Vec3::Zero(), Quat::Identity(), Vec3(0.1, -0.2, 0.3), Vec3(0.3, 0.2, -0.1));
  prepare(model, s, team);
  const Vec3 linear = momentum(s.grains), angular = angular_momentum(s.grains);
  // Each takes a corner and adds three: 62, 64, and the third has no room.
  std::vector<Vec3> furthest;
  for (const Vec3& x : ball.body.vertex)
    if (x.norm() > (1 - 1e-9) * ball.reach) furthest.push_back(x);
  REQUIRE(furthest.size() == 12);
  for (std::size_t k = 0; k < 5; ++k) {
    const Vec3 corner = furthest[2 * k].normalized();
    const double offset = 0.98 * ball.reach - corner.dot(s.grains.motion[0].position);
    apply_breaks(model, s, {{0, {Mat3::Zero(), corner, Vec3::Zero(), offset}}}, team);
    CHECK(s.grains.size() == 2 + k);
    CHECK(s.ledger.planes_dropped == (k < 2 ? 0 : k - 1));
    CHECK((*s.grains.hulls)[s.grains.hull[0]].vertices == std::min<int>(64, 62 + 2 * static_cast<int>(k)));
  }
  const Fines& f = s.ledger.fines;
  CHECK(std::abs((total_mass(s.grains) + f.mass) / (4 * pi / 3) - 1) < 1e-12);
  CHECK(std::abs(f.mass) < 1e-12);
  CHECK((momentum(s.grains) + f.momentum - linear).norm() < 1e-12 * linear.norm());
  CHECK(f.momentum.norm() < 1e-12 * linear.norm());  // the mass centre has not moved either
  CHECK((angular_momentum(s.grains) + f.angular_momentum - angular).norm() < 1e-12);
  CHECK(f.angular_momentum.norm() < 1e-3 * angular.norm());
}

TEST_CASE("a run goes on with the same bits whether rows of hulls that are gone have been freed or not") {
  Model model = cleaving_rock(true, {{Vec3::UnitX(), 1e5}, {Vec3(0.6, 0.8, 0), 2e5}}, cohesive(2e6, 2e4));
  model.materials[0].bond.reset();
  model.materials[0].fracture->splitter = Cut{true, 2e3};
  model.materials[0].fracture->limit.max_generations = 2;
  State s = crushed(model, 1, 80), freed = s;
  Team team(1);
  // All 64 cells have been cut twice: of 64 + 64 + 128 rows some 128 are of a grain, unless a list has freed some.
  s.grains.hulls = std::make_shared<const HullStore>(*s.grains.hulls);
  free_hulls(freed.grains, freed.boundary.walls, freed.contacts.guesses);
  CHECK(freed.grains.hulls->row.size() <= s.grains.hulls->row.size());
  for (State* of : {&s, &freed})
    for (std::uint64_t done = 0; done < 40;) {
      update_time_step(model, *of);
      done += run_steps(model, *of, 40 - done, team);
    }
  CHECK(s.grains.motion[5].position == freed.grains.motion[5].position);
  for (State* of : {&s, &freed}) of->grains.hull.assign(of->grains.size(), 0);
  CHECK(hash(s) == hash(freed));
}
