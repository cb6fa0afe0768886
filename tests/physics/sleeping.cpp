// SPDX-License-Identifier: LGPL-3.0-or-later
// Groups of pairs sleep while none of them can touch: runs in which they do against single steps, in which all pairs
// are looked at, bit for bit, and against all pairs of grains in every step.
#include "dem/contact/forces.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/hulls.hpp"
#include "tests/physics/all_pairs.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

Model sand() {
  Model model = model_of(solid(60e9, 0.17, 2650, 0.3, 0.5));
  model.numerics.time_step = 2e-8;
  return model;
}

/// Runs of `at_once` steps, each against single steps. At least so many pairs must overlap by more than `least` (m),
/// counted step by step. Returns how often the list was mended.
std::uint64_t compare(const Model& model, State& s, std::uint64_t at_once, int runs, std::size_t least_meetings,
                      Team& team, double least = 1e-12) {
  State awake = s;
  std::size_t meet = 0, fewest = SIZE_MAX, most = 0;
  std::uint64_t mends = 0;
  for (int run = 0; run < runs; ++run) {
    for (std::uint64_t k = 0; k < at_once; ++k) {
      const std::uint64_t before = awake.reference.mends;
      run_steps(model, awake, 1, team);
      mends += awake.reference.mends > before;
      const Meeting m = all_pairs(awake, least);
      REQUIRE(m.missed == 0);
      meet += m.pairs, fewest = std::min(fewest, m.pairs), most = std::max(most, m.pairs);
    }
    run_steps(model, s, at_once, team);
    REQUIRE(hash(s) == hash(awake));
  }
  CHECK(meet >= least_meetings);
  CHECK(most > fewest);  // some have begun to touch, or parted
  return mends;
}

void deform(State& s, const Mat3& gradient) { set_cell_rate(s, gradient * s.boundary.cell.vectors); }

/// A grain of a crowd at rest, and its velocity from now on.
void throw_grain(State& s, std::size_t i, const Vec3& velocity) { s.grains.motion[i].velocity = velocity; }

}  // namespace

TEST_CASE("a grain that flies through a sleeping crowd meets whom it meets") {
  Team team(1);
  const Model model = sand();
  for (const bool periodic : {true, false})
    for (const bool shapes : {false, true}) {
      CAPTURE(periodic, shapes);
      State s = loose(model, 120, periodic, shapes, 0, 0, team);
      throw_grain(s, 17, Vec3(20, 11, -7));
      compare(model, s, 150, 4, 50, team, 1e-9);
    }
}

TEST_CASE("two grains that fly at each other, and nobody else moves") {
  Team team(1);
  Model model = sand();
  model.numerics.skin = 1;
  for (const double back : {1.0, 0.5, 0.0}) {  // speed of the second
    CAPTURE(back);
    State s;
    for (const double x : {0.0, 2.5}) add(s, PolyEllipsoid::sphere(1e-3), Vec3(1e-3 * x, 0, 0), 2650);
    prepare(model, s, team);
    throw_grain(s, 0, Vec3(10, 0, 0)), throw_grain(s, 1, Vec3(-10 * back, 0, 0));
    compare(model, s, 500, 8, 1, team);  // touch after 1,250 to 2,500 steps
  }
}

TEST_CASE("grains of a gas, all as fast, meet head on") {
  Team team(1);
  const Model model = sand();
  for (const bool periodic : {true, false})
    for (const bool shapes : {false, true}) {
      CAPTURE(periodic, shapes);
      State s = loose(model, 120, periodic, shapes, 3, 0, team);
      compare(model, s, 200, 4, 50, team, 1e-9);
    }
}

TEST_CASE("a wall that comes at 100 m/s wakes the grains that it meets") {
  Team team(1);
  const Model model = sand();
  for (const bool shapes : {false, true}) {
    CAPTURE(shapes);
    State s = loose(model, 120, false, shapes, 0, 0, team);
    s.boundary.walls.back().velocity.z() = -100;
    compare(model, s, 60, 3, 50, team, 1e-9);
  }
}

TEST_CASE("small grains at a hundredth of the size of others meet them and each other") {
  Team team(1);
  Model model = sand();
  model.numerics.time_step = 1e-9, model.numerics.skin = 1;
  State s;
  add(s, PolyEllipsoid::sphere(1e-3), Vec3::Zero(), 2650);
  for (std::uint64_t i = 0; i < 100; ++i) {
    const double r = 1e-5 * (1 + 0.5 * random_uniform(3, i, Purpose::radius, 0));
    const double away = 1e-3 + r * (1.3 + 2 * random_uniform(4, i, Purpose::radius, 0));
    add(s, PolyEllipsoid::sphere(r), away * (random_rotation(7, i) * Vec3(1, 0, 0)), 2650);
  }
  prepare(model, s, team);
  for (std::size_t i = 1; i < s.grains.size(); ++i)
    throw_grain(s, i, 2 * (random_rotation(8, i) * Vec3(1, 0, 0)) - 1e3 * s.grains.motion[i].position);
  compare(model, s, 250, 20, 50, team);
}

TEST_CASE("needles that begin side by side spin into each other") {
  Team team(1);
  Model model = sand();
  model.numerics.skin = 1;
  const double a = 3e-4;
  State s;
  const PolyEllipsoid needle{Vec3(a, 0.1 * a, 0.1 * a), Vec3(a, 0.12 * a, 0.1 * a)};
  for (std::uint64_t i = 0; i < 27; ++i)
    add(s, needle,
        a * Vec3(2.1 * static_cast<double>(i % 3), 0.5 * static_cast<double>(i / 3 % 3),
                 0.5 * static_cast<double>(i / 9)),
        2650, Vec3::Zero(), 5e4 * (random_rotation(3, i) * Vec3(0, 0, 1)));
  prepare(model, s, team);
  compare(model, s, 100, 20, 50, team, 1e-9);
}

TEST_CASE("grains that rest in a cell that deforms at 1e5/s wake in time") {
  Team team(1);
  Model model = sand();
  model.numerics.skin = 2;  // one list: how far grains have gone is told by run
  for (const double sign : {1.0, -1.0})
    for (const bool shapes : {false, true}) {
      CAPTURE(sign, shapes);
      State s = loose(model, 100, true, shapes, 0, 0, team);
      Mat3 gradient = Mat3::Zero();
      gradient(0, 1) = 1e5 * sign, gradient(2, 2) = -2e4;
      deform(s, gradient);
      const std::uint64_t lists = s.reference.builds;
      compare(model, s, 40, 2, 50, team, 1e-9);
      CHECK(s.reference.builds == lists);
    }
}

TEST_CASE("lists are mended and made anew while groups sleep, for strays and for grains that break") {
  Model model = sand();
  model.materials[0].fracture = FractureModel{};  // no criterion: they break when told to
  Team team(1);
  for (const bool shapes : {false, true}) {
    CAPTURE(shapes);
    State s = loose(model, 200, false, shapes, 0.02, 10, team);
    const std::uint64_t lists = s.reference.builds;
    std::uint64_t mends = 0;
    for (std::size_t look = 0; look < 12; ++look) {
      for (Motion& m : s.grains.motion) m.velocity *= 0.01, m.spin *= 0.01;  // who flew before does so no longer
      throw_grain(s, 7 * look % s.grains.size(), 30 * (random_rotation(9, look) * Vec3(1, 0, 0)));
      const std::size_t i = 13 * look % s.grains.size();
      if (look % 4 == 1 && can_split(model.materials[0].fracture->splitter, s.grains, i))
        apply_breaks(model, s, {across(s, i, static_cast<int>(look % 3))}, team);
      mends += compare(model, s, 100, 1, 1, team, 1e-9);
    }
    CHECK(mends > 5);
    CHECK(s.reference.builds > lists);
  }
}

TEST_CASE("fragments that grow meet neighbours that rest") {
  Team team(1);
  Model model = growing(3e-5);
  model.numerics.time_step = 2e-8, model.numerics.skin = 0.5;
  State s;
  const double r = 3e-4;
  // Two by two, thin sides face to face: they thicken, and meet.
  PolyEllipsoid thin;
  thin.plus = Vec3(r, r, 0.3 * r), thin.minus = Vec3(r, r, 0.01 * r);
  const double below = thin.minus.z() + 0.375 * (thin.plus.z() - thin.minus.z());  // of the mass centre
  for (int i = 0; i < 20; ++i) {
    const bool upper = i % 2 == 1;
    const Vec3 x(0, 3 * r * (i / 2), upper ? 2 * below + 0.01 * r : 0);
    add(s, thin, x, 2650, Vec3::Zero(), Vec3::Zero(),
        upper ? Quat::Identity() : Quat(Eigen::AngleAxisd(pi, Vec3::UnitX())));
  }
  prepare(model, s, team);
  std::fill(s.grains.generation.begin(), s.grains.generation.end(), std::uint8_t{1});
  compare(model, s, 100, 12, 10, team, 1e-9);
}

TEST_CASE("of pairs at rest all groups sleep in which none touches, and no other") {
  Team team(1);
  const Model model = sand();
  for (const bool shapes : {false, true}) {
    CAPTURE(shapes);
    State s = loose(model, 120, true, shapes, 0, 0, team);  // one tile
    run_steps(model, s, 1, team);
    const std::vector<double> before = s.contacts.contact.stiffness;
    Odometer odometer(Mat3::Zero(), s.dt);
    odometer.wake(s.grains, s.boundary, s.reference, s.contacts);
    for (int look = 0; look < 3; ++look) {
      odometer.step(0, 0);
      ContactPass(model.law, model.pairs, s.grains, s.boundary, 0, false, s.contacts, &odometer).tile(0);
      drop_loads(s.contacts), flush(s.contacts);
    }
    CHECK(s.contacts.contact.stiffness == before);
    std::size_t asleep = 0, apart = 0, groups = 0;
    const auto width = static_cast<std::size_t>(lanes());
    for (const Bin bin : {sphere_sphere, general}) {
      const double* until = odometer.until(bin, 0);
      for (std::size_t k = s.contacts.tile[bin][0]; k < s.contacts.tile[bin][1]; k += width, ++until, ++groups) {
        bool touches = false;
        for (std::size_t l = k; l < std::min<std::size_t>(k + width, s.contacts.tile[bin][1]); ++l)
          touches = touches || s.contacts.contact.touching(l);
        apart += !touches, asleep += odometer.pairs() < *until;
        CHECK((odometer.pairs() < *until) == !touches);
      }
    }
    CHECK(groups > 5);
    CHECK(apart > 3);
    CHECK(asleep == apart);
  }
}

TEST_CASE("hulls that tumble at each other meet as if they had been looked at in every step") {
  Team team(1);
  Model model = hull_model(0.5, 1e6, 0.5);
  model.numerics.time_step = 1e-4, model.numerics.skin = 0.5;
  State s;
  // Head on, along x: gaps are used up nearly as fast as any may be.
  for (std::uint64_t i = 0; i < 36; ++i)
    add_body(s, unit_cube(),
             1.8 * Vec3(static_cast<double>(i % 4), static_cast<double>(i / 4 % 3), static_cast<double>(i / 12)),
             random_rotation(2, i), Vec3(i % 2 == 0 ? 3 : -3, 0, 0), random_rotation(3, i) * Vec3(0, 0, 0.2));
  s.boundary.cell.vectors = 1.8 * Vec3(4, 3, 3).asDiagonal();
  prepare(model, s, team);
  State awake = s;
  std::size_t fewest = SIZE_MAX, most = 0;
  for (int run = 0; run < 40; ++run) {
    for (int k = 0; k < 100; ++k) {
      run_steps(model, awake, 1, team);
      std::size_t touch = 0;
      for (std::size_t pair = 0; pair < awake.contacts.size(); ++pair) touch += awake.contacts.contact.touching(pair);
      fewest = std::min(fewest, touch), most = std::max(most, touch);
    }
    run_steps(model, s, 100, team);
    REQUIRE(hash(s) == hash(awake));
  }
  CHECK(most > fewest + 3);
}

TEST_CASE("readings of the odometer grow by twice the way, the strain of the reach, growth and walls") {
  State s;
  add(s, PolyEllipsoid::sphere(0.1), Vec3(3, 4, 0), 1000);
  add_floor(s);
  s.boundary.walls[0].velocity = Vec3(7, 0, 0.5);  // along itself it comes no nearer
  s.reference.largest = 0.1, s.reference.skin = 0.01;
  for (auto& tile : s.contacts.tile) tile.assign(2, 0);
  const double dt = 1e-3, rate = 2, reach = 0.2 + 0.06;
  Mat3 affine = Mat3::Zero();
  affine(0, 1) = rate;
  Odometer still(Mat3::Zero(), dt), sheared(affine, dt);
  for (Odometer* o : {&still, &sheared}) o->wake(s.grains, s.boundary, s.reference, s.contacts);
  still.step(0, 0.3);
  CHECK(still.pairs() == Approx(2 * 0.3 * dt).epsilon(1e-9));
  CHECK(still.walls() == Approx((0.3 + 0.5) * dt).epsilon(1e-9));
  still.grow(1e-3);
  CHECK(still.pairs() == Approx(2 * 0.3 * dt + 2e-3).epsilon(1e-9));
  CHECK(still.walls() == Approx((0.3 + 0.5) * dt + 1e-3).epsilon(1e-9));
  sheared.step(0, 0);
  CHECK(sheared.pairs() == Approx(dt * rate * reach).epsilon(1e-9));
  sheared.step(10, 0);  // speeds are against the motion that was: off by the strain since, at 5 m from the origin
  const double strain = 10 * dt * rate, now = rate / (1 - strain);
  CHECK(sheared.pairs() ==
        Approx(dt * rate * reach + dt * now * (reach + 2 * strain * (5 + dt * (rate * 5 + 0.5)))).epsilon(1e-9));
}

TEST_CASE("a body that turns far in a step may have reached anything about it") {
  State s;
  const PolyEllipsoid needle{Vec3(0.1, 0.01, 0.01), Vec3(0.1, 0.01, 0.02)};
  add(s, needle, Vec3::Zero(), 1000), add(s, PolyEllipsoid::sphere(1), Vec3(2, 0, 0), 1000);
  s.reference.largest = 1;
  for (auto& tile : s.contacts.tile) tile.assign(2, 0);
  Odometer o(Mat3::Zero(), 1);
  o.wake(s.grains, s.boundary, s.reference, s.contacts);
  const double radius = s.grains.motion[0].radius;
  o.step(0, 0.09 * radius);
  CHECK(o.pairs() == Approx(0.18 * radius).epsilon(1e-9));
  o.step(1, 0.11 * radius);
  CHECK(o.pairs() == Approx(0.18 * radius + 2 * (0.11 * radius + 2)).epsilon(1e-9));
}
