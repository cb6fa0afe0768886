// SPDX-License-Identifier: LGPL-3.0-or-later
// What ends a stage and its legs, when its rows are due and what is told of it: each rule by hand, of states whose
// stresses are set.
#include "dem/rve/measure.hpp"
#include "tests/staged.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

TEST_CASE("a stress ends a leg once it is met, from the side that the leg comes from") {
  const Model own = grains();
  State s = lattice(own);
  s.dt = 1e-6;
  const auto ended = [&](const Stage& one, const StageNow& now, const Vec3& stress) {
    Programme test = test_of({one});
    test.now = now;
    return leg_ended(test, press(s, stress));
  };
  const double below = 1 - 1e-9, above = 1 + 1e-9;
  Stage up = stage(StageKind::compress), down = stage(StageKind::unload);
  up.until.stress = down.until.stress = 4e5;
  CHECK(ended(up, {}, {1e5, 1e5, 4e5 * below}) == EndedBy::nothing);
  CHECK(ended(up, {}, {1e5, 1e5, 4e5 * above}) == EndedBy::stress);
  CHECK(ended(down, {}, {1e5, 1e5, 4e5 * above}) == EndedBy::nothing);
  CHECK(ended(down, {}, {1e5, 1e5, 4e5 * below}) == EndedBy::stress);
  up.until = ends_by(&StageEnds::deviator, 4e5), down.until = ends_by(&StageEnds::deviator, 4e5);
  CHECK(ended(up, {}, {1e5, 3e5, 6e5 * below}) == EndedBy::nothing);
  CHECK(ended(up, {}, {1e5, 3e5, 6e5 * above}) == EndedBy::deviator);
  CHECK(ended(down, {}, {1e5, 3e5, 6e5 * above}) == EndedBy::nothing);
  CHECK(ended(down, {}, {1e5, 3e5, 6e5 * below}) == EndedBy::deviator);
  Stage again = stage(StageKind::reload);
  again.to_turn = true;
  CHECK(ended(again, {.turned = 7e5}, {1e5, 1e5, 7e5 * below}) == EndedBy::nothing);
  CHECK(ended(again, {.turned = 7e5}, {1e5, 1e5, 7e5 * above}) == EndedBy::stress);
  Stage all = stage(StageKind::compress);
  all.all = true, all.until.stress = 1e6;
  for (int k = 0; k < 3; ++k)
    for (const double sense : {1.0, -1.0}) {  // each axis within a thousandth
      Vec3 stress = Vec3::Constant(1e6);
      stress[k] += sense * 1.01e3;
      CHECK(ended(all, {}, stress) == EndedBy::nothing);
      stress[k] -= sense * 0.02e3;
      CHECK(ended(all, {}, stress) == EndedBy::stress);
    }
}

TEST_CASE("cycles turn back an amplitude from where they began, and end there") {
  const Model own = grains();
  State s = lattice(own);
  s.dt = 1e-6;
  for (const Swing swing : {Swing::stress, Swing::deviator}) {
    Stage cycle = stage(StageKind::cyclic);
    cycle.swing = swing, cycle.amplitude = 1e5, cycle.cycles = 2;
    CHECK(cycle.legs() == 5);
    const double others = swing == Swing::deviator ? 2e5 : 0;
    for (std::uint64_t leg = 0; leg < 5; ++leg) {
      const double sense = leg % 2 == 0 ? 1 : -1, turn = 5e5 + (leg == 4 ? 0 : sense * 1e5);
      Programme test = test_of({cycle});
      test.now.leg = leg, test.now.leg_from = 5e5;
      const auto ended = [&](double reading) { return leg_ended(test, press(s, {1e5, 3e5, reading + others})); };
      CHECK(ended(turn - sense) == EndedBy::nothing);
      CHECK(ended(turn + sense) == EndedBy::cycles);
    }
  }
  Stage cycle = stage(StageKind::cyclic, 0.5);  // of strain: by time
  cycle.amplitude = 0.01, cycle.cycles = 2;
  for (std::uint64_t leg = 0; leg < 5; ++leg) {
    Programme test = test_of({cycle});
    test.now.leg = leg, test.now.began = 1, test.now.leg_began = 3;
    const double end = 3 + (leg == 0 || leg == 4 ? 0.02 : 0.04);
    CHECK(leg_until(test) == Approx(end).epsilon(1e-14));
    s.time = end - 1e-8;
    CHECK(leg_ended(test, s) == EndedBy::nothing);
    s.time = end + 1e-8;
    CHECK(leg_ended(test, s) == EndedBy::cycles);
  }
}

TEST_CASE("strain, void ratio, time and rest end a stage; one that gets no further fails") {
  const Model own = grains();
  const State made = lattice(own);
  Stage one = stage(StageKind::compress);
  StageNow now{.began = 2, .leg_began = 2, .strain = 0.005};
  State s = made;
  s.dt = 1e-6;
  const auto ended = [&] {
    Programme test = test_of({one});
    test.now = now;
    return leg_ended(test, s);
  };
  one.until.strain = 0.2;  // at 0.5/s: by time, to round-off
  s.time = 2.4 - 1e-8;
  CHECK(ended() == EndedBy::nothing);
  s.time = 2.4;
  CHECK(ended() == EndedBy::strain);
  one.stress_rate = 1e4, one.until.stress = 1e9, s.time = 2.1;  // by a stress: the way from where the stage began
  const double way = strain - now.strain;                       // the cell has gone 0.01 of 4 R
  one.until.strain = way * (1 + 1e-9);
  CHECK(ended() == EndedBy::nothing);
  one.until.strain = way * (1 - 1e-9);
  CHECK(ended() == EndedBy::strain);

  one = stage(StageKind::compress);
  const double voids = void_ratio(s);
  for (const StageKind kind : {StageKind::compress, StageKind::unload}) {  // the volume follows the axis
    const double side = kind == StageKind::unload ? -1 : 1;
    one.kind = kind, now.void_ratio = voids;
    one.until.void_ratio = voids - 0.1 * side;
    CHECK(ended() == EndedBy::nothing);
    one.until.void_ratio = voids + 0.1 * side;  // behind it from the start
    CHECK(ended() == EndedBy::void_ratio);
  }
  one = stage(StageKind::compress), one.lateral = Lateral::held;
  for (const double from : {0.1, -0.1}) {  // from above and from below
    now.void_ratio = voids + from, one.until.void_ratio = voids - 1e-9 * from;
    CHECK(ended() == EndedBy::nothing);
    one.until.void_ratio = voids + 1e-9 * from;
    CHECK(ended() == EndedBy::void_ratio);
  }
  one = stage(StageKind::relax, 0);
  one.until.time = 0.3, s.time = 2.3 - 1e-8;
  CHECK(ended() == EndedBy::nothing);
  s.time = 2.3;
  CHECK(ended() == EndedBy::time);
  s.time = 2.1, one.until = ends_by(&StageEnds::unbalanced_force, unbalanced_force(s) * (1 - 1e-9));
  for (Vec3& f : s.grains.force) f = Vec3(1, 0, 0);
  one.until.unbalanced_force = unbalanced_force(s) * (1 - 1e-9);
  CHECK(ended() == EndedBy::nothing);
  one.until.unbalanced_force = unbalanced_force(s) * (1 + 1e-9);
  CHECK(ended() == EndedBy::unbalanced_force);

  one = stage(StageKind::compress);
  one.until.stress = 1e12, one.max_strain = way * (1 + 1e-6);
  s.time = 2;
  CHECK(ended() == EndedBy::nothing);
  one.max_strain = way * (1 - 1e-6);
  CHECK(ended() == EndedBy::limit);
  one.max_strain = 0.6, one.max_time = 0.5, s.time = 2.5 - 1e-8;
  CHECK(ended() == EndedBy::nothing);
  s.time = 2.5;
  CHECK(ended() == EndedBy::limit);
  CHECK(std::string(name_of(EndedBy::limit)) == "limit");
  CHECK(std::string(name_of(EndedBy::unbalanced_force)) == "unbalanced_force");
  CHECK(std::string(name_of(EndedBy::stress)) == "stress");
}

TEST_CASE("a leg ends no later than by its rate, its time, or the time of its ramp") {
  Stage one = stage(StageKind::compress, -0.5);
  const auto until = [&](const StageNow& now) {
    Programme test = test_of({one});
    test.now = now;
    return leg_until(test);
  };
  const StageNow now{.began = 2, .leg_began = 3, .leg_from = 1e5};
  CHECK(until(now) == Approx(2 + 0.6 / 0.5));  // max_strain
  one.until.strain = 0.1;
  CHECK(until(now) == Approx(2 + 0.1 / 0.5));
  one.until.time = 0.05, one.max_time = 0.04;
  CHECK(until(now) == Approx(2.04));
  one.max_time = 0.06;
  CHECK(until(now) == Approx(2.05));
  one = stage(StageKind::compress);
  one.stress_rate = 1e4, one.until.stress = 2e5;  // the ramp takes ten seconds, and a tenth more is left to it
  CHECK(until(now) == Approx(2 + 1.1 * 10));
  one.stress_rate = 1e6;
  CHECK(until(now) == Approx(2 + 0.6 / 0.5));
  one = stage(StageKind::cyclic);
  one.swing = Swing::stress, one.amplitude = 1e5, one.cycles = 1;
  CHECK(until(now) == Approx(3 + 2 * 0.6 / 0.5));
  one = stage(StageKind::relax, 0);
  CHECK(until(now) == inf);
}

TEST_CASE("rows are due at even parts of a leg, of a way to a void ratio at even parts of that, and at its end") {
  Stage one = stage(StageKind::compress);
  one.until.strain = 0.2;
  const auto due = [&](const StageNow& now) {
    Programme test = test_of({one});
    test.now = now;
    return row_until(test);
  };
  for (std::uint64_t row = 0; row < 9; ++row)
    CHECK(due({.row = row, .began = 2, .leg_began = 2}) == Approx(2 + 0.04 * static_cast<double>(row + 1)));
  CHECK(due({.row = 9, .began = 2, .leg_began = 2}) == 2 + 0.2 / 0.5);
  CHECK(due({.row = 90, .began = 2, .leg_began = 2}) == 2 + 0.2 / 0.5);
  one.until = ends_by(&StageEnds::void_ratio, 0.6);
  const double span = (0.8 - 0.6) / 1.8 / 0.5;
  CHECK(due({.row = 2, .began = 2, .leg_began = 2, .void_ratio = 0.8}) == Approx(2 + 0.3 * span));
  one.lateral = Lateral::held;  // then not known beforehand
  CHECK(due({.row = 2, .began = 2, .leg_began = 2, .void_ratio = 0.8}) == Approx(2 + 0.3 * 1.2));
}

TEST_CASE("what is left to the next row is by stress where a stress ends the leg") {
  const Model own = grains();
  State s = lattice(own);
  s.dt = 1e-6;
  Stage one = stage(StageKind::compress);
  one.axis = 2, one.until.stress = 6e5;
  Programme test = test_of({one});
  test.now = {.level = 3, .began = 0, .leg_began = 0, .leg_from = 1e5};
  Landing landing = leg_landing(test);
  REQUIRE(landing.left);
  CHECK((landing.near == inf && landing.axis == 2));
  CHECK(landing.left(press(s, {1e5, 1e5, 2e5})) == Approx(1e5 + 5e5 * 0.4 - 2e5));
  CHECK(landing.left(press(s, {1e5, 1e5, 6e5 * (1 + 1e-9)})) == 0);
  test.stages[0].kind = StageKind::unload, test.stages[0].until.stress = 1e5, test.now.leg_from = 6e5;
  landing = leg_landing(test);
  CHECK(landing.left(press(s, {1e5, 1e5, 5e5})) == Approx(5e5 - (6e5 - 5e5 * 0.4)));

  Stage cycle = stage(StageKind::cyclic);  // a leg within goes from one turn to the other
  cycle.swing = Swing::stress, cycle.amplitude = 1e5, cycle.cycles = 2;
  test = test_of({cycle});
  test.now.leg_from = 5e5;
  for (const auto& [leg, from, to] : {std::tuple{0u, 5e5, 6e5}, {1u, 6e5, 4e5}, {2u, 4e5, 6e5}, {4u, 4e5, 5e5}}) {
    test.now.leg = leg, test.now.level = 2;
    const double level = from + 0.3 * (to - from), reading = from + 0.1 * (to - from);
    CHECK(leg_landing(test).left(press(s, {1e5, 1e5, reading})) == Approx(std::abs(level - reading)));
  }

  Stage all = stage(StageKind::compress);
  all.all = true, all.until.stress = 1e6;
  test = test_of({all});
  landing = leg_landing(test);
  CHECK((landing.near == 0 && landing.left));
  CHECK(landing.left(press(s, Vec3::Constant(5e4))) == Approx(5e4));  // of the mean, to a tenth of the stress
  test.now.level = 9;
  CHECK(landing.left(press(s, Vec3::Constant(9e5))) == inf);
  CHECK(landing.left(press(s, Vec3::Constant(1e6))) == 0);

  Stage timed = stage(StageKind::compress);
  timed.until.strain = 0.1;
  test = test_of({timed});
  CHECK(!leg_landing(test).left);
  test.stages[0].until.void_ratio = 0.1, test.now.void_ratio = 9;  // it has that of the lattice
  landing = leg_landing(test);
  REQUIRE(landing.left);
  CHECK((landing.left(s) == inf && landing.near == 0));
}

TEST_CASE("rows and levels are counted as they are passed, legs and stages as they end") {
  const Model own = grains();
  State s = lattice(own);
  s.dt = 1e-6;
  Stage cycle = stage(StageKind::cyclic);
  cycle.cycles = 1, cycle.amplitude = 0.05;
  Stage to = stage(StageKind::compress);
  to.until.stress = 6e5;
  Programme test = test_of({cycle, to});
  s.time = 0.035;  // rows of the first half of a cycle are 0.01 s apart
  count_row(test, s);
  CHECK((test.now.row == 3 && test.now.row_time == 0.035));
  s.time = 0.04;
  count_row(test, s);
  CHECK(test.now.row == 4);
  for (const std::uint64_t leg : {1u, 2u}) {
    test.now.leg_begun = test.now.begun = true;
    end_leg(test, EndedBy::cycles);
    CHECK((test.now.leg == leg && test.now.stage == 0 && test.now.begun && !test.now.leg_begun));
  }
  end_leg(test, EndedBy::cycles);
  CHECK((test.now.leg == 0 && test.now.stage == 1 && !test.now.begun));
  test.now = {.leg = 1, .begun = true};
  end_leg(test, EndedBy::time);
  CHECK((test.now.leg == 0 && test.now.stage == 1));

  test.now = {.stage = 1, .leg_from = 1e5};
  for (const auto& [stress, levels] : {std::pair{1.4e5, 0u}, {1.6e5, 1u}, {3.2e5, 4u}, {7e5, 10u}}) {
    count_row(test, press(s, {1e5, 1e5, stress}));
    CHECK(test.now.level == levels);
  }
}

TEST_CASE("the part of a test that is done: stages, legs, and of a leg its levels or its time") {
  State s;
  Stage cycle = stage(StageKind::cyclic);
  cycle.cycles = 1, cycle.amplitude = 0.05;
  Stage to = stage(StageKind::compress);
  to.until.stress = 6e5;
  Programme test = test_of({to, cycle});
  CHECK(stages_done(test, s) == 0);
  test.now = {.level = 3, .leg_begun = true};
  CHECK(stages_done(test, s) == Approx(0.5 * 0.3));
  test.now = {.stage = 1, .leg = 1, .leg_begun = true, .leg_began = 2};
  s.time = 2.05;  // of 0.2 s
  CHECK(stages_done(test, s) == Approx(0.5 * (1 + (1 + 0.25) / 3)));
  test.now = {.stage = 2};
  CHECK(stages_done(test, s) == 1);
}

TEST_CASE("a stage that has not met its end says which, how far it is from it, and what has stopped it") {
  const Model own = grains();
  State s = lattice(own);
  press(s, {1e5, 2e5, 4e5});
  s.time = 3;
  Stage one = stage(StageKind::compress);
  one.name = "press", one.until.stress = 6e5, one.until.strain = 0.5, one.max_time = 1;
  Programme test = test_of({stage(StageKind::relax), one});
  test.now.stage = 1, test.now.began = 2, test.now.strain = 0.005;
  CHECK(unmet(test, s) ==
        "stage 2 (\"press\") has not met its end, a stress in Pa of 6e+05 (it is 4e+05) or a strain of 0.5 (it is "
        "0.005), "
        "by a time of 1 s (max_time, or max_strain at strain_rate)");
  test.stages[1].max_strain = 0.004, test.stages[1].until = ends_by(&StageEnds::deviator, 6e5);
  CHECK(unmet(test, s) ==
        "stage 2 (\"press\") has not met its end, a deviator in Pa of 6e+05 (it is 2.5e+05), by a strain "
        "of 0.004 (max_strain)");
}
