// SPDX-License-Identifier: LGPL-3.0-or-later
// Pairs of hulls that are apart sleep in runs of many steps: held bit for bit against single steps, in which nobody
// sleeps, and after each of these against all pairs.
#include "dem/contact/sleeping_hulls.hpp"

#include "dem/rve/state_hash.hpp"
#include "dem/shape/separation.hpp"
#include "tests/cleaving_cells.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// Of grains of size 1: a speed of 1 is a ten thousandth of a grain a step.
Model crowd_model(double skin) {
  Model model = hull_model(0.5, 1e6, 0.5);
  model.numerics.time_step = 1e-4, model.numerics.skin = skin;
  return model;
}

/// Bodies at rest on a lattice, each turned at random; in a periodic cell or a box, whose last wall is above.
State crowd(const Model& model, const Polyhedron& body, const Vec3& spacing, const std::array<int, 3>& count,
            bool periodic, Team& team) {
  State s;
  std::uint64_t id = 0;
  for (int z = 0; z < count[2]; ++z)
    for (int y = 0; y < count[1]; ++y)
      for (int x = 0; x < count[0]; ++x)
        add_body(s, body, (Vec3(x, y, z) + Vec3::Constant(0.5)).cwiseProduct(spacing), random_rotation(2, id++));
  const Vec3 size = spacing.cwiseProduct(Vec3(count[0], count[1], count[2]));
  if (periodic) {
    s.boundary.cell.vectors = size.asDiagonal();
  } else {
    add_box(s, size.x());
    s.boundary.walls[3].point.y() = size.y(), s.boundary.walls[5].point.z() = size.z();
  }
  prepare(model, s, team);
  return s;
}

/// Hulls that are in each other deeper than `least` by looking at all pairs from nothing, and of those the ones that do
/// not touch on the list.
struct Meeting {
  std::size_t pairs = 0, missed = 0;
};

Meeting all_pairs(const State& s, double least) {
  const Grains& g = s.grains;
  const Mat3& cell = s.boundary.cell.vectors;
  const bool periodic = s.boundary.cell.periodic();
  Meeting m;
  for (std::size_t i = 0; i < g.size(); ++i)
    for (std::size_t j = i + 1; j < g.size(); ++j) {
      Vec3 shift = g.motion[j].position - g.motion[i].position;
      if (periodic) {
        Vec3 f = cell.inverse() * shift;
        for (double& x : f) x = std::round(x);
        shift -= cell * f;
      }
      if (shift.norm() > g.motion[i].radius + g.motion[j].radius) continue;
      const Mat3 back = g.frame[i].axes.transpose(), turn = back * g.frame[j].axes;
      const HullView a = (*g.hulls)[g.hull[i]], b = (*g.hulls)[g.hull[j]];
      Vec3 direction = Vec3::Zero();
      if (face_separation(a, b, turn, back * shift, direction) > -least) continue;
      direction.setZero();
      if (separation(a, b, turn, back * shift, direction) > 0) continue;  // edges part them
      ++m.pairs;
      bool found = false;
      for (std::size_t k = s.contacts.begin[hull_hull]; k < s.contacts.begin[hull_hull + 1]; ++k)
        found = found || (s.contacts.pair[k].a == i && s.contacts.pair[k].b == j && s.contacts.contact.touching(k));
      m.missed += !found;
    }
  return m;
}

struct Seen {
  std::size_t fewest = SIZE_MAX, most = 0;  // pairs in each other
  std::uint64_t mends = 0, lists = 0;
};

/// Runs of `at_once` steps against single steps.
Seen compare(const Model& model, State& s, std::uint64_t at_once, int runs, Team& team) {
  State awake = s;
  Seen seen;
  const std::uint64_t lists = s.reference.builds;
  for (int run = 0; run < runs; ++run) {
    for (std::uint64_t k = 0; k < at_once; ++k) {
      const std::uint64_t before = awake.reference.mends;
      run_steps(model, awake, 1, team);
      seen.mends += awake.reference.mends > before;
      const Meeting m = all_pairs(awake, 1e-6);
      REQUIRE(m.missed == 0);
      seen.fewest = std::min(seen.fewest, m.pairs), seen.most = std::max(seen.most, m.pairs);
    }
    run_steps(model, s, at_once, team);
    REQUIRE(hash(s) == hash(awake));
  }
  seen.lists = s.reference.builds - lists;
  return seen;
}

}  // namespace

TEST_CASE("a hull that flies through a sleeping crowd meets whom it meets, and a wall drives all before it") {
  Team team(1);
  for (const bool flies : {true, false}) {
    CAPTURE(flies);
    const Model model = crowd_model(flies ? 0.5 : 0.1);
    State s = crowd(model, unit_cube(), Vec3::Constant(1.7), {3, 3, 3}, flies, team);
    if (flies)
      s.grains.motion[4].velocity = Vec3(20, 11, -7);
    else
      s.boundary.walls.back().velocity.z() = -70;  // 100 m/s for grains of 0.3 mm in steps of 20 ns
    const Seen seen = compare(model, s, flies ? 100 : 40, flies ? 10 : 8, team);
    CHECK(seen.most > seen.fewest + 1);
  }
}

TEST_CASE("hulls that rest in a cell that is sheared by 0.2 % a step wake in time") {
  Team team(2);
  const Model model = crowd_model(2);  // few lists
  for (const double sign : {1.0, -1.0}) {
    CAPTURE(sign);
    State s = crowd(model, unit_cube(), Vec3::Constant(1.7), {4, 4, 4}, true, team);
    Mat3 gradient = Mat3::Zero();
    gradient(0, 1) = 20 * sign, gradient(2, 2) = -10;  // 1e5/s in steps of 20 ns
    set_cell_rate(s, gradient * s.boundary.cell.vectors);
    const Seen seen = compare(model, s, 60, 3, team);
    CHECK(seen.most > seen.fewest + 5);
    CHECK(seen.lists <= 1);
  }
}

TEST_CASE("needles that rest side by side and spin wake before their tips meet") {
  Team team(1);
  const Model model = crowd_model(0.5);
  State s;
  const Polyhedron needle = box_between(Vec3(-0.5, -0.05, -0.05), Vec3(0.5, 0.05, 0.05));
  for (std::uint64_t i = 0; i < 27; ++i) {
    const Vec3 place(1.1 * static_cast<double>(i % 3), 0.3 * static_cast<double>(i / 3 % 3),
                     0.3 * static_cast<double>(i / 9));
    add_body(s, needle, place, Quat::Identity(), Vec3::Zero(), 40 * (random_rotation(3, i) * Vec3(0, 0, 1)));
  }
  prepare(model, s, team);
  const Seen seen = compare(model, s, 100, 6, team);
  CHECK(seen.most > seen.fewest + 3);
}

TEST_CASE("small hulls at a hundredth of the size of another meet it and each other") {
  Team team(1);
  Model model = crowd_model(1);
  model.numerics.time_step = 1e-6;
  State s;
  add_body(s, unit_cube(), Vec3::Zero(), Quat::Identity());
  const Polyhedron small = box_between(Vec3::Constant(-5e-3), Vec3::Constant(5e-3));
  for (std::uint64_t i = 0; i < 25; ++i)
    add_body(s, small, Vec3(0.02 * static_cast<double>(i % 5), 0.02 * static_cast<double>(i / 5), 0.515),
             random_rotation(7, i), random_rotation(8, i) * Vec3(3, 0, 0) - Vec3(0, 0, 8));
  prepare(model, s, team);
  const Seen seen = compare(model, s, 150, 10, team);
  CHECK(seen.most > seen.fewest + 5);
}

TEST_CASE("lists are mended and made anew while pairs sleep, for strays and for hulls that break") {
  Team team(1);
  Model model = crowd_model(0.2);
  model.materials[0].fracture = cleaving(false);
  model.materials[0].fracture->criteria.clear();  // they break when told to
  State s = crowd(model, unit_cube(), Vec3::Constant(1.7), {4, 4, 4}, false, team);
  std::uint64_t mends = 0, lists = 0;
  for (std::size_t look = 0; look < 8; ++look) {
    s.grains.motion[7 * look % s.grains.size()].velocity = random_rotation(9, look) * Vec3(25, 0, 0);
    if (look % 4 == 1)
      apply_breaks(model, s, {{13 * look % s.grains.size(), {Mat3::Zero(), random_vector(look, 1).normalized()}}},
                   team);
    const Seen seen = compare(model, s, 100, 1, team);
    mends += seen.mends, lists += seen.lists;
  }
  CHECK(s.grains.size() == 66);
  CHECK(mends > 2);
  CHECK(lists > 2);
}

TEST_CASE("a pair sleeps until the ways of the two have grown by its gap: shifts, turns, the cell's part") {
  State s;
  add_body(s, unit_cube(), Vec3::Zero(), Quat::Identity());
  add_body(s, unit_cube(), Vec3(2, 0, 0), Quat::Identity());
  const double radius = s.grains.motion[0].radius, gap = 1;
  REQUIRE(radius == Approx(std::sqrt(0.75)));
  Team team(1);
  const auto sleeps = [&](auto&& change) {
    State moved = s;
    SleepingHulls sleep;
    sleep.wake(moved.grains, moved.boundary.cell, 1, 4);
    CHECK(!sleep.asleep(0, 0, 1));
    sleep.rest(0, 0, 1, gap);
    change(moved);
    sleep.go(moved.grains, moved.boundary.cell, team);
    return sleep.asleep(0, 0, 1);
  };
  for (const double share : {0.99, 1.01}) {
    CHECK(sleeps([&](State& m) { m.grains.motion[1].position.x() -= share * gap; }) == (share < 1));
    CHECK(sleeps([&](State& m) {
            m.grains.motion[0].position.x() += 0.5 * share * gap, m.grains.motion[1].position.x() -= 0.5 * share * gap;
          }) == (share < 1));
    // A small turn's chord is its angle: 0.5 % is kept in hand.
    const double angle = share * gap / (10 * radius * 1.005);
    CHECK(sleeps([&](State& m) {
            for (Quat& q : m.grains.orientation) q = rotation_by(angle * Vec3::UnitZ()) * q;
            for (Motion& x : m.grains.motion) x.position.y() += 0.4 * share * gap;
          }) == (share < 1));
  }
  s.boundary.cell.vectors = 10 * Mat3::Identity();
  for (const double share : {0.99, 1.01})  // a cell that stretches moves two within 4 m by this
    CHECK(sleeps([&](State& m) {
            m.boundary.cell.vectors(0, 0) += 10 * share * gap / 4;
            m.grains.motion[1].position.x() += 2 * share * gap / 4;
          }) == (share < 1));
}
