// SPDX-License-Identifier: LGPL-3.0-or-later
// How the tests of a peridynamic grain end: after as many steps, rounds and shares of the load as their choices say.
#include "tests/lattices.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// A small ball between platens, and forces that its bonds bear and do not.
struct Ball : Platens {
  double first = 0, most = 0;  // E d^2 s_c: the first bond breaks; the last that is held

  Ball() : Platens(lattice_of(110), 0) {
    solid.mend(), solid.dilate(answer);
    first = 1 / solid.largest_stretch(std::vector<std::uint8_t>(lattice.octet.size() - 1, 0xff));
    most = strength() / 1.04;
    solid.mend();
  }
  /// The steps that a wave needs for as many passages through the ball, and one.
  int passages(double count) {
    const double step = 0.9 * 2 / solid.highest_frequency();
    return static_cast<int>(count / (solid.wave_speed() * step)) + 1;
  }
  HoldTest held(double force, PointColumns& u, const HoldLimits& limits = {}) {
    solid.mend(), u = times(force, answer);
    return hold_test(solid, times(force, load), u, limits);
  }
  CrackRun run(double force, PointColumns& u, const CrackChoice& choice, double share = 1) {
    solid.mend(), u = times(share * force, answer);
    return crack_run(solid, times(force, load), u, choice, share);
  }
};

double largest(const PointColumns& u) {
  double most = 0;
  for (std::size_t k = 0; k < u.size(); ++k) most = std::max(most, std::abs(u[k]));
  return most;
}

}  // namespace

TEST_CASE("a load that breaks nothing grows to the whole and no further, and is held after a wait at each share") {
  Ball ball;
  const int quiet = ball.passages(CrackChoice::quiet), pause = ball.passages(CrackChoice::pause);
  REQUIRE(quiet < CrackChoice::most_steps - 1);
  const double force = 0.8 * ball.first;
  for (const auto& [share, raises] : {std::pair{1.0, 0}, {0.97, 1}, {0.9, 3}}) {
    PointColumns u;
    const CrackRun run = ball.run(force, u, {}, share);
    CHECK(run.end == CrackEnd::holds);
    CHECK(run.load_factor == 1);
    CHECK(run.steps == raises * (pause + 1) + quiet + 1);
    CHECK(run.lost == 0);
    CHECK(run.clusters.pieces == 0);
    double off = 0;  // waves have died: it is at rest under the whole load
    for (std::size_t k = 0; k < u.size(); ++k) off = std::max(off, std::abs(u[k] - force * ball.answer[k]));
    CHECK(off < 1e-3 * largest(u));
  }
}

TEST_CASE("what has parted is followed for as many passages as it is told to") {
  Ball ball;
  PointColumns u;
  std::vector<int> steps;
  for (const double time : {1.0, 2.0, 3.5}) {
    CrackChoice choice;
    choice.time = time;
    const CrackRun run = ball.run(1.3 * ball.most, u, choice);
    REQUIRE(run.end == CrackEnd::parts);
    CHECK(run.clusters.pieces >= 2);
    CHECK(run.lost > 0);
    ball.solid.mend();  // its frequency is that of the whole ball
    steps.push_back(run.steps - ball.passages(time));
  }
  CHECK(steps[0] % 10 == 0);  // looked for at every tenth step
  CHECK((steps[1] == steps[0] && steps[2] == steps[0]));
}

TEST_CASE("a run in which nothing large enough parts ends once the patches have gone five times as far as at rest") {
  Ball ball;
  PointColumns u;
  CrackChoice choice;
  choice.smallest_piece = 0.9;
  for (const bool crumbs : {false, true}) {
    choice.crumbs = crumbs;
    const CrackRun run = ball.run(1.5 * ball.most, u, choice);
    const double far = largest(u) / (1.5 * ball.most * largest(ball.answer));
    CHECK(far > CrackChoice::torn);
    CHECK(far < 1.5 * CrackChoice::torn);
    CHECK(run.steps % 10 == 0);
    CHECK(run.load_factor == 1);
    CHECK(run.end == (run.clusters.pieces + run.clusters.crumbs > 1 ? CrackEnd::parts : CrackEnd::stalls));
    if (!crumbs) CHECK(run.end == CrackEnd::stalls);
  }
}

TEST_CASE("the test by static answers ends where its limits are") {
  Ball ball;
  PointColumns u;
  const HoldTest low = ball.held(0.99 * ball.first, u);
  CHECK((low.holds() && low.rounds == 0 && low.solves == 0 && low.lost == 0 && low.work == 1));
  const HoldLimits patient{.rounds = 2000, .work = 1e9};
  const double above = 1.02 * ball.first;
  REQUIRE(above < ball.most);
  const HoldTest some = ball.held(above, u, patient);
  REQUIRE(some.holds());
  CHECK(some.rounds > 0);
  CHECK(some.solves > some.rounds);
  CHECK(some.lost > 0);
  CHECK(some.work > 1);
  CHECK(some.work == Approx(dot(ball.load, u) / (above * dot(ball.load, ball.answer))).epsilon(1e-12));
  const HoldTest none = ball.held(above, u, {.rounds = 0});
  CHECK((none.verdict == Hold::unsettled && none.solves == 0 && none.lost > 0));
  const HoldTest one = ball.held(1.5 * ball.most, u, {.rounds = 1, .work = 1e9, .failed = 1e9});
  CHECK((one.verdict == Hold::unsettled && one.rounds == 1 && one.solves == 1));
  const HoldTest little = ball.held(above, u, {.rounds = 2000, .work = 0.9});
  CHECK((little.verdict == Hold::unsettled && little.rounds == 0));
  const HoldTest failed = ball.held(above, u, {.rounds = 2000, .work = 1e9, .failed = 0.9});
  CHECK((failed.verdict == Hold::fails && failed.rounds == 0 && failed.solves == 1));
  CHECK(ball.held(1.1 * ball.most, u, patient).verdict == Hold::fails);
}

TEST_CASE("a sweep breaks the bonds that are too long, finds the dilations of what is left, and what it gave up") {
  Ball ball;
  PeridynamicSolid& solid = ball.solid;
  const std::size_t points = ball.lattice.size();
  const PointColumns below = times(0.99 * ball.first, ball.answer), above = times(4 * ball.first, ball.answer);
  double lost = 0;
  solid.mend();
  CHECK(solid.break_above(below, 1, lost) == 0);
  CHECK(solid.break_above(above, 4.01, lost) == 0);
  CHECK(solid.largest_breakable_stretch() == Approx(4).epsilon(1e-12));
  CHECK(lost == 0);
  const double had = solid.dilate(above, true);
  std::size_t ends = 0;
  REQUIRE(solid.break_above(above, 1, lost) > 1);
  for (std::size_t b = 0; b < ball.lattice.bond.size(); ++b)
    ends += static_cast<std::size_t>(__builtin_popcount(ball.lattice.bond[b] & ~unsigned{solid.intact()[b]}));
  std::vector<double> told;
  for (std::size_t i = 0; i < points; ++i) told.push_back(solid.dilation(i));
  CHECK(had - solid.dilate(above, true) == Approx(lost).epsilon(1e-9));
  for (std::size_t i = 0; i < points; ++i) CHECK(solid.dilation(i) == told[i]);
  double again = 0;  // what is broken is no longer asked, but would be too long
  CHECK(solid.break_above(above, 1, again) == 0);
  CHECK(again == 0);
  CHECK(solid.largest_breakable_stretch() == Approx(4).epsilon(1e-12));
  solid.mend();
  CHECK(2 * solid.break_above(above, 1, again) == ends);
  solid.mend(), solid.keep(std::vector<bool>(points, true));
  CHECK(solid.break_above(above, 1, again) == 0);
  CHECK(solid.largest_breakable_stretch() == 0);
}

TEST_CASE("an answer that is said to hold balances to a thousandth, whatever broke on the way to it") {
  Ball ball;
  for (const double share : {1.02, 1.1, 1.3}) {
    const double force = share * ball.first;
    REQUIRE(force < ball.most);
    PointColumns u, pull(ball.lattice.size());
    const HoldTest test = ball.held(force, u, {.rounds = 2000, .work = 1e9});
    REQUIRE(test.holds());
    CHECK(test.solves > test.rounds);  // one roughly for each round, and one that counts
    ball.solid.dilate(u), ball.solid.pull(pull);
    for (std::size_t k = 0; k < u.size(); ++k) pull[k] += force * ball.load[k];
    CHECK(std::sqrt(dot(pull, pull) / dot(ball.load, ball.load)) < 1.001 * HoldLimits::tolerance * force);
    double lost = 0;
    CHECK(ball.solid.break_above(u, 1, lost) == 0);
  }
}

TEST_CASE("a point between fixed neighbours gives way to a force as the slope of its own says") {
  for (const double nu : {0.25, 0.15}) {  // of the first, dilation takes nothing off
    const PointLattice lattice = make_lattice(lattice_sphere(0.5), lattice_of(110), 7, 0);
    PeridynamicSolid solid(lattice, nu);
    double lost = 0;
    REQUIRE(solid.break_above(random_field(lattice, 3), 4.2, lost) > 20);
    PointColumns on(lattice.size()), off = on, force = on;
    solid.flexibility(on, off);
    double stiffest = 0;
    for (std::size_t i = 0; i < lattice.size(); i += 7) {
      Mat3 slope, inverse;
      inverse << on(i, 0), off(i, 2), off(i, 1), off(i, 2), on(i, 1), off(i, 0), off(i, 1), off(i, 0), on(i, 2);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        PointColumns u(lattice.size());
        u(i, axis) = 1;
        solid.dilate(u), solid.pull(force);
        for (std::size_t c = 0; c < 3; ++c)
          slope(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(axis)) = -force(i, c);
      }
      stiffest = std::max(stiffest, slope.diagonal().maxCoeff());
      const Mat3 off_one = slope * inverse - Mat3::Identity();
      if (nu == 0.25)  // less a thousandth of the stiffest for points that have lost their bonds
        CHECK(off_one.cwiseAbs().maxCoeff() < 0.02);
      else
        CHECK(off_one.cwiseAbs().maxCoeff() < 0.5);
    }
    CHECK(stiffest > 0);
  }
}

TEST_CASE("the last share that is held is the largest power that is: the next one is not held, and it stands at rest") {
  Ball ball;
  PointColumns u(ball.lattice.size()), alone;
  for (int above = 0; above < 16; ++above) {  // what is tried last holds for some, and fails for others
    const double force = std::pow(CrackChoice::raise, above + 1.5) * ball.most;
    const LastHold last = last_hold(ball.solid, times(force, ball.load), times(force, ball.answer), u);
    REQUIRE(last.test.holds());
    const std::vector<std::uint8_t> left = ball.solid.intact();
    const double power = -std::log(last.share) / std::log(CrackChoice::raise);
    CHECK(power == Approx(std::round(power)).epsilon(1e-9));
    CHECK(power >= 1);
    const HoldTest test = ball.held(last.share * force, alone);
    CHECK(test.holds());
    double off = 0;
    for (std::size_t k = 0; k < u.size(); ++k) off = std::max(off, std::abs(u[k] - alone[k]));
    CHECK(off < 1e-9 * largest(u));
    CHECK(ball.solid.intact() == left);
    CHECK(last.test.lost == Approx(test.lost).epsilon(1e-9));
    CHECK(last.test.work == Approx(test.work).epsilon(1e-9));
    CHECK(last.test.rounds >= test.rounds);
    PointColumns next;
    CHECK(!ball.held(CrackChoice::raise * last.share * force, next).holds());
    ball.solid.mend();
  }
  const double endless = 1e13;
  CHECK(!last_hold(ball.solid, times(endless, ball.load), times(endless, ball.answer), u).test.holds());
}

TEST_CASE("what goes with the farthest is told apart: four points and the share asked for, or a crumb, or nothing") {
  const PointLattice lattice = make_lattice(lattice_sphere(0.5), lattice_of(110), 7, 0);
  const PeridynamicSolid solid(lattice, poisson);
  std::vector<std::size_t> order(lattice.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return lattice.point[a].z() > lattice.point[b].z(); });
  const double all = static_cast<double>(lattice.size());
  const auto moved = [&](std::size_t count, double least, bool crumbs) {
    PointColumns u(lattice.size());
    for (std::size_t k = 0; k < count; ++k) u(order[k], 2) = 1 + 0.01 * static_cast<double>(k % 3);
    const Clusters c = torn_apart(solid, u, least, crumbs);
    std::size_t off = 0;  // points that are not in the smaller part as they should be
    for (std::size_t k = 0; k < order.size(); ++k)
      off += (c.piece[order[k]] == 1) != (2 * count > order.size() ? k >= count : k < count);
    return std::tuple{c.pieces, c.crumbs, off};
  };
  CHECK(moved(10, 9.5 / all, false) == std::tuple{2, 0, std::size_t{0}});
  CHECK(moved(10, 10.5 / all, false) == std::tuple{1, 0, std::size_t{10}});
  CHECK(moved(10, 10.5 / all, true) == std::tuple{1, 1, std::size_t{0}});
  CHECK(moved(4, 0, false) == std::tuple{2, 0, std::size_t{0}});
  CHECK(moved(3, 0, true) == std::tuple{1, 0, std::size_t{3}});
  CHECK(moved(lattice.size() - 10, 9.5 / all, false) ==
        std::tuple{2, 0, std::size_t{0}});  // the larger part is the rest
}
