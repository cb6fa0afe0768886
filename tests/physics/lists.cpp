// SPDX-License-Identifier: LGPL-3.0-or-later
// Lists of near pairs against all pairs: while candidates serve several lists, while lists are mended, while grains are
// sorted.
#include <algorithm>

#include "dem/contact/neighbours.hpp"
#include "dem/kernel/look_ahead.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/breakage.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/rve/step.hpp"
#include "dem/shape/common_normal.hpp"
#include "dem/state/order.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// Loose grains in a cell that shears, or between walls of which one comes in; speed in m/s, rate in 1/s.
State loose(const Model& model, std::size_t grains, bool periodic, bool shapes, double speed, double rate, Team& team) {
  State s;
  const double fraction = 0.45, size = std::cbrt(static_cast<double>(grains) * 1.225e-10 / fraction);
  for (const auto& sphere : random_packing(Vec3::Constant(size), {"truncated-normal", 3e-4, 5e-5, 1e-4, 4.5e-4},
                                           fraction, grains, periodic, 11)
                                .spheres) {
    PolyEllipsoid shape = PolyEllipsoid::sphere(sphere.radius);
    const std::size_t i = s.grains.size();
    if (shapes && i % 3 == 0) shape.plus.x() *= 0.6, shape.minus.y() *= 0.8;
    set_grain(s.grains, i,
              {.shape = shape,
               .position = sphere.position,
               .velocity = speed * (random_rotation(6, i) * Vec3(1, 0, 0)),
               .orientation = random_rotation(5, i),
               .density = 2650});
  }
  sort_in_space(s.grains);
  if (periodic)
    s.boundary.cell.vectors = size * Mat3::Identity();
  else
    add_box(s, size), s.boundary.walls.back().velocity.z() = -rate * size;
  prepare(model, s, team);
  if (periodic) {
    Mat3 gradient = Mat3::Zero();
    gradient.diagonal() = Vec3(-1, 0.6, -0.8), gradient(0, 1) = 0.8;
    set_cell_rate(s, rate * size * gradient);
  }
  return s;
}

bool listed(const Contacts& c, bool wall, std::size_t i, std::size_t j, std::array<std::int16_t, 3> image,
            bool touching) {
  for (std::size_t k = wall ? c.begin[first_wall] : 0; k < (wall ? c.size() : c.begin[first_wall]); ++k)
    if (c.pair[k].a == i && c.pair[k].b == j && c.pair[k].image == image) return !touching || c.contact.touching(k);
  return false;
}

/// Vector from i to the nearest image of j, and that image, which is the only near one: no cell here is that small.
std::pair<Vec3, std::array<std::int16_t, 3>> nearest(const Mat3& cell, const Vec3& i, const Vec3& j) {
  Vec3 r = j - i;
  std::array<std::int16_t, 3> image{};
  if (cell(0, 0) == 0) return {r, image};
  const Vec3 f = cell.inverse() * r;
  for (int k = 0; k < 3; ++k) image[static_cast<std::size_t>(k)] = static_cast<std::int16_t>(-std::lround(f[k]));
  r += cell * Vec3(image[0], image[1], image[2]);
  return {r, image};
}

/// Pairs of spheres, and spheres and walls, that the list lacks though less than the skin was between them where their
/// ways begin.
std::size_t too_near(const State& s) {
  const Grains& g = s.grains;
  const NeighbourReference& ref = s.reference;
  std::size_t count = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    if (!is_sphere(g, i)) continue;
    const double reach = g.motion[i].radius + (1 - 1e-9) * ref.skin;
    for (std::size_t j = i + 1; j < g.size(); ++j) {
      const auto [r, image] = nearest(ref.cell, ref.position[i], ref.position[j]);
      if (is_sphere(g, j) && r.norm() < g.motion[j].radius + reach)
        count += !listed(s.contacts, false, i, j, image, false);
    }
    for (std::size_t w = 0; w < s.boundary.walls.size(); ++w)
      if (s.boundary.walls[w].facing().dot(ref.position[i] - ref.wall_point[w]) < reach)
        count += !listed(s.contacts, true, i, w, {}, false);
  }
  return count;
}

/// Pairs that overlap by more than `least`, by looking at all, and how many of them do not touch on the list.
struct Meeting {
  std::size_t pairs = 0, missed = 0;
};

Meeting all_pairs(const State& s, double least) {
  const Grains& g = s.grains;
  Meeting m;
  for (std::size_t i = 0; i < g.size(); ++i) {
    for (std::size_t j = i + 1; j < g.size(); ++j) {
      const auto [r, image] = nearest(s.boundary.cell.vectors, g.motion[i].position, g.motion[j].position);
      double overlap = g.motion[i].radius + g.motion[j].radius - r.norm();
      if (overlap > least && !(is_sphere(g, i) && is_sphere(g, j))) {
        const Frame a = frame_of(g, i), b = frame_of(g, j);
        const Vec3 apart = b.origin - g.motion[j].position + r + g.motion[i].position - a.origin;
        overlap = cold_common_normal({g.shape[i], g.shape[j], a.axes.transpose() * b.axes, a.axes.transpose() * apart})
                      .overlap;
      }
      if (overlap > least) ++m.pairs, m.missed += !listed(s.contacts, false, i, j, image, true);
    }
    for (std::size_t w = 0; w < s.boundary.walls.size(); ++w) {
      const Wall& wall = s.boundary.walls[w];
      const Vec3 inward = wall.facing();
      const Vec3 tip = is_sphere(g, i) ? Vec3(-g.motion[i].radius * inward) : surface_arm(g, i, -inward);
      if (inward.dot(g.motion[i].position + tip - wall.point) < -least)
        ++m.pairs, m.missed += !listed(s.contacts, true, i, w, {}, true);
    }
  }
  return m;
}

}  // namespace

TEST_CASE("kernels that look ahead find grains there beyond the last pair") {
  Team team(1);
  State s = loose(model_of(solid(60e9, 0.17, 2650, 0.3, 0.5)), 200, false, false, 0, 0, team);
  const std::vector<Index>& b = s.contacts.plan.b;
  REQUIRE(b.size() == s.contacts.size() + overrun + grains_ahead);
  for (std::size_t k = s.contacts.size(); k < b.size(); ++k) CHECK(b[k] < s.grains.size());
}

TEST_CASE("no contact is missed while candidates serve several lists") {
  Model model = model_of(solid(60e9, 0.17, 2650, 0.3, 0.5));
  model.numerics.skin = 0.02;  // many lists
  Team team(1);
  for (const bool periodic : {true, false}) {
    State s = loose(model, 200, periodic, false, 0.3, 50, team);
    const std::uint64_t lists = s.reference.builds;
    std::size_t meet = 0;
    for (int look = 0; look < 30; ++look) {
      run_steps(model, s, 200, team);
      const Meeting m = all_pairs(s, 1e-12);
      meet += m.pairs;
      REQUIRE(m.missed == 0);
      REQUIRE(too_near(s) == 0);
    }
    CHECK(meet > 100);
    CHECK(s.reference.builds > lists + 5);
  }
}

TEST_CASE("no contact is missed while lists are mended, for strays and for grains that break") {
  Material sand = solid(60e9, 0.17, 2650, 0.3, 0.2);
  sand.fracture = FractureModel{};  // no criterion: they break when told to
  const Model model = model_of(sand);
  Team team(2);
  for (const bool periodic : {true, false})
    for (const bool shapes : {true, false}) {
      INFO("periodic " << periodic << ", shapes " << shapes);
      State s = loose(model, 400, periodic, shapes, 0.02, 10, team);
      const std::uint64_t lists = s.reference.builds;
      std::uint64_t mends = 0, last = 0;
      std::size_t meet = 0;
      for (int look = 0; look < 60; ++look) {
        if (look % 3 == 0)
          s.grains.motion[static_cast<std::size_t>(7 * look) % s.grains.size()].velocity +=
              30 * (random_rotation(9, static_cast<std::uint64_t>(look)) * Vec3(1, 0, 0));
        if (look % 4 == 1) {
          const auto i = static_cast<std::size_t>(13 * look) % s.grains.size();
          if (can_split(sand.fracture->splitter, s.grains, i)) apply_breaks(model, s, {across(s, i, look % 3)}, team);
        }
        s.next_estimate = s.steps;  // of the time step
        for (int part = 0; part < 10; ++part) {
          update_time_step(model, s);
          run_steps(model, s, 20, team);
          mends += s.reference.mends > last ? s.reference.mends - last : 0, last = s.reference.mends;
        }
        const Meeting m = all_pairs(s, 1e-9);
        meet += m.pairs;
        REQUIRE(m.missed == 0);
        REQUIRE(too_near(s) == 0);
      }
      CHECK(meet > 1000);
      CHECK(mends > 30);
      CHECK(s.reference.builds > lists + 3);
    }
}

TEST_CASE("putting the grains in order anew changes nothing but their order") {
  Material sand = solid(60e9, 0.17, 2650, 0.3, 0.5);
  sand.fracture = FractureModel{};
  sand.fracture->springs = CohesiveSprings{4, 1.77e6};
  Model model = model_of(sand);
  model.numerics.skin = 0.02;  // many lists
  Team team(1);
  for (const bool periodic : {true, false}) {
    State kept = loose(model, 200, periodic, true, 0.3, 50, team);
    run_steps(model, kept, 400, team);
    for (const std::size_t i : {3u, 50u, 120u, 51u}) apply_breaks(model, kept, {across(kept, i, 1)}, team);
    update_time_step(model, kept);
    REQUIRE(kept.bonds.size() == 16);
    State ordered = kept;
    kept.sorted = 1000000, ordered.sorted = 0;
    for (State* s : {&kept, &ordered}) run_steps(model, *s, 400, team);
    CHECK(ordered.sorted == ordered.grains.size());
    CHECK(ordered.grains.id != kept.grains.id);
    CHECK(ordered.ledger.friction == Approx(kept.ledger.friction).epsilon(1e-9));
    for (std::size_t i = 0; i < kept.grains.size(); ++i) {
      const auto at = std::find(ordered.grains.id.begin(), ordered.grains.id.end(), kept.grains.id[i]);
      REQUIRE(at != ordered.grains.id.end());
      const Motion &m = kept.grains.motion[i],
                   &o = ordered.grains.motion[static_cast<std::size_t>(at - ordered.grains.id.begin())];
      // Sums in another order: round-off, ten times larger with each impact.
      REQUIRE((m.position - o.position).norm() < 1e-10 * m.radius);
      REQUIRE((m.spin - o.spin).norm() <= 1e-8 * (1 + m.spin.norm()));
    }
  }
}

TEST_CASE("a mended list knows how far the walls have gone since it was made: they may come back") {
  const Model model = model_of(solid(60e9, 0.17, 2650));
  Team team(1);
  State s;
  for (int k = 0; k < 200; ++k) add(s, PolyEllipsoid::sphere(1), Vec3(10.0 * (k % 20), 10.0 * (k / 20), 20), 2650);
  add_floor(s);
  prepare(model, s, team);
  const double skin = s.skin, back = 0.3 * skin;
  s.boundary.walls[0].point.z() -= back;
  const std::vector<Index> few{7};
  for (const double gap : {1.2, 1.4}) {  // of the skin, now; of the wall where the ways began less by 0.3
    State now = s;
    now.grains.motion[7].position.z() = 1 - back + gap * skin;
    mend_contacts(now.grains, now.boundary, now.skin, model.materials.size(), few, {}, now.contacts, now.reference,
                  team, false);
    CHECK(listed(now.contacts, true, 7, 0, {}, false) == (gap < 1.3));
    CHECK(too_near(now) == 0);
  }
}

TEST_CASE("the bound of a grain's way holds while the cell stretches by a seventh, in runs of any length") {
  Model model = model_of(solid(60e9, 0.17, 2650));
  model.numerics.skin = 1, model.numerics.time_step = 1e-3;
  Team team(1);
  const double stretch = 1.0 / 7;
  for (const std::uint64_t at_once : {1u, 50u, 1000u})
    for (const double direction : {-1.0, 1.0}) {
      CAPTURE(at_once, direction);
      State s;
      for (const double x : {4.0, 16.0}) add(s, PolyEllipsoid::sphere(1), Vec3(x, 10, 10), 2650);
      s.boundary.cell.vectors = 20 * Mat3::Identity();
      prepare(model, s, team);
      Mat3 rate = Mat3::Zero();
      rate(0, 0) = 20 * stretch;
      set_cell_rate(s, rate);
      s.grains.motion[1].velocity.x() += 0.2 * direction;
      const auto way = [&] {
        const Mat3 affine = s.boundary.cell.vectors / 20;
        return (s.grains.motion[1].position - affine * s.reference.position[1]).norm();
      };
      for (std::uint64_t k = 0; k < 1000; k += at_once) {
        run_steps(model, s, at_once, team);
        REQUIRE(s.reference.builds == 1);
        REQUIRE(s.reference.travelled >= way());
      }
      CHECK(way() == Approx(0.2).epsilon(1e-6));  // no force: its way is that of its own speed
    }
}

TEST_CASE("the bound of a grain's way is little above what the fastest one goes, of spheres and of bodies") {
  Model model = model_of(solid(60e9, 0.17, 2650));
  model.numerics.skin = 1, model.numerics.time_step = 1e-3;
  Team team(1);
  for (const bool round : {true, false}) {
    State s;
    add(s, {Vec3(round ? 1 : 1.2, 1, 1), Vec3(1, 1, 1)}, Vec3(4, 10, 10), 2650, Vec3(0.1, 0, 0));
    add(s, PolyEllipsoid::sphere(1), Vec3(16, 10, 10), 2650, Vec3(0, 0.2, 0));
    prepare(model, s, team);
    run_steps(model, s, 100, team);
    REQUIRE(s.reference.builds == 1);
    CHECK((s.reference.travelled >= 0.02 && s.reference.travelled < 0.03));
  }
}

TEST_CASE("what a grain has gone grows with the cell when it goes no further by itself") {
  Model model = model_of(solid(60e9, 0.17, 2650));
  model.numerics.skin = 1, model.numerics.time_step = 1e-3;
  Team team(1);
  State s;
  for (const double x : {4.0, 16.0}) add(s, PolyEllipsoid::sphere(1), Vec3(x, 10, 10), 2650);
  s.boundary.cell.vectors = 20 * Mat3::Identity();
  prepare(model, s, team);
  s.grains.motion[1].position.x() += 0.2, s.reference.travelled = 0.2;  // as a look at the grains finds it
  Mat3 rate = Mat3::Zero();
  rate(0, 0) = 20.0 / 7;
  set_cell_rate(s, rate);
  for (int k = 1; k <= 1000; ++k) {
    run_steps(model, s, 1, team);
    REQUIRE(s.reference.builds == 1);
    const double way =
        s.grains.motion[1].position.x() - s.boundary.cell.vectors(0, 0) / 20 * s.reference.position[1].x();
    CHECK(way == Approx(0.2 * (1 + k / 7e3)).epsilon(1e-9));
    REQUIRE(s.reference.travelled >= way * (1 - 1e-12));
  }
}

TEST_CASE("while a cell deforms by an eighth under one list the bound holds of every grain, and no pair is missed") {
  Model model = model_of(solid(1e8, 0.17, 2650, 0.3, 0.5));
  model.numerics.skin = 2;
  Team team(1);
  constexpr std::uint64_t steps = 400;
  struct Case {
    double sign, speed;     // of the gradient; m/s
    std::uint64_t at_once;  // steps of a run
  };
  for (const Case& c : {Case{1, 0, 1}, {-1, 0, 1}, {1, 1e-2, 1}, {-1, 1e-2, 1}, {1, 0, 100}, {-1, 1e-2, 100}}) {
    CAPTURE(c.sign, c.speed, c.at_once);
    State s = loose(model, 200, true, false, c.speed, 0, team);
    Mat3 gradient = Mat3::Zero();
    gradient.diagonal() = Vec3(-0.7, 0.5, 0.1), gradient(0, 1) = 0.4;
    gradient *= c.sign / (6 * static_cast<double>(steps) * s.dt * gradient.norm());
    set_cell_rate(s, gradient * s.boundary.cell.vectors);
    double strained = 0;  // under one list
    for (std::uint64_t k = 0; k < steps; k += c.at_once) {
      run_steps(model, s, c.at_once, team);
      const Mat3 affine = s.boundary.cell.vectors * s.reference.cell.inverse();
      strained = std::max(strained, (affine - Mat3::Identity()).norm());
      double furthest = 0;
      for (std::size_t i = 0; i < s.grains.size(); ++i)
        furthest = std::max(furthest, (s.grains.motion[i].position - affine * s.reference.position[i]).norm());
      REQUIRE(s.reference.travelled >= furthest - 1e-12 * s.skin);
      REQUIRE(all_pairs(s, 1e-12).missed == 0);
      REQUIRE(too_near(s) == 0);
    }
    CHECK(strained > 0.12);
  }
}

namespace {

/// Runs of `at_once` steps, held bit for bit against single steps, after each of which all pairs are looked at. How
/// many pairs overlapped by more than `least` (m), counted step by step.
std::size_t look_at_all(const Model& model, State& s, std::uint64_t at_once, int runs, double least, Team& team) {
  State single = s;
  std::size_t meet = 0;
  for (int run = 0; run < runs; ++run) {
    for (std::uint64_t k = 0; k < at_once; ++k) {
      run_steps(model, single, 1, team);
      const Meeting m = all_pairs(single, least);
      REQUIRE(m.missed == 0);
      meet += m.pairs;
    }
    run_steps(model, s, at_once, team);
    REQUIRE(hash(s) == hash(single));
  }
  return meet;
}

}  // namespace

TEST_CASE("nobody is missed by a grain that flies through a crowd at rest, nor by a wall that comes at 100 m/s") {
  Team team(1);
  Model model = model_of(solid(60e9, 0.17, 2650, 0.3, 0.5));
  model.numerics.time_step = 2e-8, model.numerics.skin = 0.05;
  for (const bool flies : {true, false})
    for (const bool shapes : {false, true}) {
      CAPTURE(flies, shapes);
      State s = loose(model, 120, false, shapes, 0, 0, team);
      if (flies)
        s.grains.motion[17].velocity = Vec3(20, 11, -7);
      else
        s.boundary.walls.back().velocity.z() = -100;
      CHECK(look_at_all(model, s, 60, flies ? 8 : 3, 1e-9, team) > 50);
    }
}

TEST_CASE("nobody is missed among grains a hundredth of the size of others, nor in a crowd sheared at 1e5/s") {
  Team team(1);
  Model model = model_of(solid(60e9, 0.17, 2650, 0.3, 0.5));
  model.numerics.time_step = 1e-9, model.numerics.skin = 0.5;
  State s;
  add(s, PolyEllipsoid::sphere(1e-3), Vec3::Zero(), 2650);
  for (std::uint64_t i = 0; i < 100; ++i) {
    const double r = 1e-5 * (1 + 0.5 * random_uniform(3, i, Purpose::radius, 0));
    const double away = 1e-3 + r * (1.3 + 2 * random_uniform(4, i, Purpose::radius, 0));
    const Vec3 place = away * (random_rotation(7, i) * Vec3(1, 0, 0));
    add(s, PolyEllipsoid::sphere(r), place, 2650, 2 * (random_rotation(8, i) * Vec3(1, 0, 0)) - 1e3 * place);
  }
  prepare(model, s, team);
  CHECK(look_at_all(model, s, 250, 16, 1e-12, team) > 50);
  model.numerics.time_step = 2e-8, model.numerics.skin = 0.05;
  for (const double sign : {1.0, -1.0}) {
    State sheared = loose(model, 100, true, true, 0, 0, team);
    Mat3 gradient = Mat3::Zero();
    gradient(0, 1) = 1e5 * sign, gradient(2, 2) = -2e4;
    set_cell_rate(sheared, gradient * sheared.boundary.cell.vectors);
    const std::uint64_t lists = sheared.reference.builds;
    CHECK(look_at_all(model, sheared, 40, 2, 1e-9, team) > 50);
    CHECK(sheared.reference.builds > lists);
  }
}
