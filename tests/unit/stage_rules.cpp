// SPDX-License-Identifier: LGPL-3.0-or-later
// What a stage asks of grains, walls and cell, how it begins and what it reads: each rule by hand, of states whose
// stresses are set.
#include "dem/contact/forces.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/servo.hpp"
#include "tests/staged.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

Loading loading_of(const Stage& s, const StageNow& now = {}) {
  const Model own = grains();
  Model model = own;
  Programme test = test_of({s});
  test.now = now;
  set_stage(own, model, test);
  CHECK(test.axis == s.axis);
  CHECK(test.loading.initial_size == Vec3::Constant(4 * R));
  return test.loading;
}

}  // namespace

TEST_CASE("an axis is compressed or unloaded at its rate; the others stand") {
  for (const auto& [kind, rate, sense] : {std::tuple{StageKind::compress, 0.5, 1.0},
                                          {StageKind::reload, 0.5, 1.0},
                                          {StageKind::unload, 0.5, -1.0},
                                          {StageKind::shear, 0.5, 1.0},
                                          {StageKind::shear, -0.5, -1.0}}) {
    for (int axis = 0; axis < 3; ++axis) {
      Stage s = stage(kind, rate);
      s.axis = axis;
      const Loading l = loading_of(s);
      CHECK((l.driven && !l.holds && !l.isochoric && !l.velocity_gradient));
      for (int k = 0; k < 3; ++k) {
        CHECK(!l.axes[static_cast<std::size_t>(k)].stress);
        CHECK(l.axes[static_cast<std::size_t>(k)].strain_rate == (k == axis ? -sense * 0.5 : 0));
      }
      Programme test = test_of({s});
      Model model = grains();
      set_stage(grains(), model, test);
      CHECK(test.strain_rate == sense * 0.5);
    }
  }
  Stage cycle = stage(StageKind::cyclic);
  cycle.cycles = 2;
  for (std::uint64_t leg = 0; leg < 5; ++leg)
    CHECK(loading_of(cycle, {.leg = leg}).axes[2].strain_rate == (leg % 2 == 0 ? -0.5 : 0.5));
  for (const StageKind still : {StageKind::deposit, StageKind::relax}) CHECK(!loading_of(stage(still)).driven);
}

TEST_CASE("axes keep the stress that is given, or that the stage has found; the volume; all axes go to one stress") {
  const StageNow now{.leg_began = 3, .stress = Vec3(1e5, 2e5, 4e5)};
  Stage held = stage(StageKind::shear, -0.5);
  held.lateral = Lateral::held, held.axis = 1;
  Loading l = loading_of(held, now);
  CHECK((l.holds && l.driven && !l.isochoric));
  CHECK((l.axes[0].stress == -1e5 && l.axes[2].stress == -4e5 && !l.axes[1].stress));
  CHECK((l.axes[0].max_rate == 1 && l.axes[2].max_rate == 1 && l.axes[0].strain_rate == 0));
  CHECK(l.axes[1].strain_rate == 0.5);
  held.lateral_stress = 7e5;
  l = loading_of(held, now);
  CHECK((l.axes[0].stress == -7e5 && l.axes[2].stress == -7e5 && !l.axes[1].stress));

  Stage kept = stage(StageKind::shear);
  kept.lateral = Lateral::volume;
  l = loading_of(kept, now);
  CHECK((l.isochoric && !l.holds && l.axes[2].strain_rate == -0.5));

  Stage all = stage(StageKind::compress);
  all.all = true, all.until.stress = 9e5;
  l = loading_of(all, now);
  CHECK((l.driven && !l.holds));
  for (const AxisControl& axis : l.axes) CHECK((axis.stress == -9e5 && axis.max_rate == 0.5 && axis.strain_rate == 0));
  all.kind = StageKind::hold, all.until.stress = {};
  l = loading_of(all, now);
  CHECK(l.holds);
  for (int k = 0; k < 3; ++k) CHECK(l.axes[static_cast<std::size_t>(k)].stress == -now.stress[k]);
  all.all = false, all.axis = 1;
  l = loading_of(all, now);
  CHECK((l.holds && l.axes[1].stress == -2e5 && l.axes[1].max_rate == 0.5 && !l.axes[0].stress && !l.axes[2].stress));
}

TEST_CASE("a ramp of stress goes on from what the stage found, from the time at which its leg began") {
  const StageNow now{.began = 2, .leg_began = 3, .stress = Vec3(1e5, 2e5, 4e5)};
  for (const auto& [kind, sense] : {std::pair{StageKind::compress, 1.0}, {StageKind::unload, -1.0}}) {
    Stage s = stage(kind, 5);
    s.stress_rate = 1e4;
    const Loading l = loading_of(s, now);
    CHECK((l.holds && l.axes[2].max_rate == 5 && l.axes[2].strain_rate == 0));
    for (const double t : {3.0, 4.0, 8.0}) CHECK(-stress_asked(l.axes[2], t) == Approx(4e5 + sense * 1e4 * (t - 3)));
  }
}

TEST_CASE("a shear in a plane moves along its first direction, across its second") {
  for (const double sense : {1.0, -1.0}) {
    Stage s = stage(StageKind::shear, sense * 0.5);
    s.plane = {{0, 2}}, s.axis = 2;
    const Loading l = loading_of(s);
    REQUIRE(l.velocity_gradient);
    Mat3 expected = Mat3::Zero();
    expected(0, 2) = sense * 0.5;
    CHECK(*l.velocity_gradient == expected);
    CHECK(l.driven);
  }
}

TEST_CASE(
    "friction and damping are a stage's own or the material's, walls keep theirs, gravity is the last that was named") {
  Model own = grains(0.5);
  own.materials[0].damping = 0.1, own.materials[1].friction = 0.3, own.motion.gravity = Vec3(0, 0, -1);
  make_pair_laws(own);
  std::vector<Stage> stages(4, stage(StageKind::compress));
  stages[1].friction = 0.2, stages[1].damping = 0.4, stages[1].gravity = Vec3(0, 0, -2);
  stages[2].gravity = Vec3(1, 0, 0);
  Programme test = test_of(stages);
  Model model = own;
  const std::array friction{0.5, 0.2, 0.5, 0.5}, damping{0.1, 0.4, 0.1, 0.1};
  const std::array gravity{Vec3(0, 0, -1), Vec3(0, 0, -2), Vec3(1, 0, 0), Vec3(1, 0, 0)};
  for (std::size_t k = 0; k < 4; ++k) {
    test.now.stage = k;
    set_stage(own, model, test);
    CHECK(model.materials[0].friction == friction[k]);
    CHECK(model.pairs[0].friction[slide_spring] == friction[k]);
    CHECK(model.pairs[1].friction[slide_spring] == 0.3);  // with the wall
    CHECK(model.materials[1].friction == 0.3);
    CHECK(model.damping[0] == damping[k]);
    CHECK(model.motion.gravity == gravity[k]);
  }
}

TEST_CASE("a stage begins from where the sample is, with cell and walls at rest; the last unloading is remembered") {
  const Model own = grains();
  Model model = own;
  State s = lattice(own);
  const double size = s.boundary.cell.vectors(0, 0);
  press(s, {1e5, 2e5, 4e5});
  s.time = 7;
  set_cell_rate(s, 1e-3 * Mat3::Identity());
  Programme test = test_of({stage(StageKind::compress), stage(StageKind::unload), stage(StageKind::compress)},
                           Vec3(4 * R, 5 * R, 6 * R));
  test.stages[0].axis = 0, test.stages[1].axis = 1;
  test.now.leg = 3, test.now.leg_begun = true;
  begin_stage(own, model, s, 12, test);
  const StageNow& now = test.now;
  CHECK((now.begun && !now.leg_begun && now.leg == 0 && now.first_row == 12 && now.began == 7));
  CHECK((now.stress - Vec3(1e5, 2e5, 4e5)).norm() < 1e-6);
  CHECK(now.strain == Approx(1 - size / (4 * R)));
  CHECK(now.void_ratio == Approx(std::pow(size, 3) / (8 * 4 / 3.0 * pi * R * R * R) - 1));
  CHECK(now.turned == 0);
  CHECK(s.boundary.cell.rate.isZero(0));
  test.now.stage = 1, s.time = 8;
  begin_stage(own, model, s, 20, test);
  CHECK(now.turned == Approx(2e5));
  CHECK(now.strain == Approx(1 - size / (5 * R)));
  press(s, {3e5, 3e5, 3e5});
  test.now.stage = 2;
  begin_stage(own, model, s, 30, test);
  CHECK(now.turned == Approx(2e5));  // of the last unloading

  State box;
  add_box(box, 1);
  add(box, PolyEllipsoid::sphere(0.1), Vec3::Constant(0.5), 2650);
  Team team(1);
  prepare(own, box, team);
  for (Wall& wall : box.boundary.walls) wall.velocity = Vec3(1, 2, 3);
  begin_stage(own, model, box, 0, test);
  for (const Wall& wall : box.boundary.walls) CHECK(wall.velocity.isZero(0));
}

TEST_CASE("springs that no friction holds any more give up what they hold, to friction") {
  for (const double friction : {0.0, 0.2}) {
    const Model own = grains();
    Model model = own;
    State s = lattice(own);
    const double normal = elastic_energy(own.law, s.contacts);
    for (std::size_t k = 0; k < s.contacts.size(); ++k)
      if (s.contacts.contact.touching(k)) {
        Contact c = s.contacts.contact[k];
        c.spring[slide_spring] = s.contacts.touch[k].normal.unitOrthogonal(), c.compliance = 2e-6;
        s.contacts.contact.set(k, c);
      }
    const double held = elastic_energy(own.law, s.contacts) - normal;
    REQUIRE(held == Approx(24 * 0.5 * 2e-6));  // 24 springs of 1 N
    Programme test = test_of({stage(StageKind::compress)});
    test.stages[0].friction = friction;
    s.ledger.friction = 1;
    begin_stage(own, model, s, 0, test);
    CHECK(s.ledger.friction == Approx(friction > 0 ? 1 : 1 + held).epsilon(1e-12));
    CHECK(elastic_energy(own.law, s.contacts) == Approx(friction > 0 ? normal + held : normal).epsilon(1e-12));
  }
}

TEST_CASE("a leg begins at its reading; cycles turn about where the first of them began") {
  const Model own = grains();
  Model model = own;
  State s = lattice(own);
  s.time = 3, s.servo.drift = Vec3(1, 2, 3);
  Stage cycle = stage(StageKind::cyclic);
  cycle.cycles = 2, cycle.swing = Swing::deviator, cycle.amplitude = 1e5;
  Programme test = test_of({cycle});
  press(s, {1e5, 2e5, 4e5});
  begin_leg(own, model, s, test);
  CHECK((test.now.leg_begun && test.now.leg_began == 3 && test.now.leg_from == Approx(2.5e5)));
  CHECK((s.servo.drift.isZero(0) && s.servo.at == 3));
  CHECK(s.boundary.cell.rate(2, 2) == Approx(-0.5 * 4 * R));
  press(s, {1e5, 2e5, 6e5});
  test.now.leg = 1, test.now.row = 4, test.now.level = 5;
  begin_leg(own, model, s, test);
  CHECK((test.now.leg_from == Approx(2.5e5) && test.now.row == 0 && test.now.level == 0));
  CHECK(s.boundary.cell.rate(2, 2) == Approx(0.5 * 4 * R));

  Stage to = stage(StageKind::compress);
  to.until.stress = 8e5;
  test = test_of({to});
  begin_leg(own, model, s, test);
  CHECK(test.now.leg_from == Approx(6e5));
  test.stages[0].until = ends_by(&StageEnds::deviator, 8e5);
  begin_leg(own, model, s, test);
  CHECK(test.now.leg_from == Approx(4.5e5));
  test.stages[0].until = ends_by(&StageEnds::stress, 8e5), test.stages[0].all = true;
  begin_leg(own, model, s, test);
  CHECK(test.now.leg_from == Approx(3e5));  // the mean
}

TEST_CASE("readings of a stage: the way of its axis, its stress, and of a plane the angle and the shear stress") {
  const Model own = grains();
  State s = lattice(own);
  const double size = s.boundary.cell.vectors(0, 0);
  press(s, {1e5, 2e5, 6e5});
  s.time = 5;
  Stage one = stage(StageKind::compress);
  one.axis = 1;
  Programme test = test_of({one}, Vec3(4 * R, 5 * R, 6 * R));
  test.now.began = 3;
  CHECK(stage_strain(test, s) == Approx(1 - size / (5 * R)));
  CHECK(stage_stress(test, s) == Approx(2e5));
  test.stages[0].swing = Swing::stress;
  CHECK(stage_swing(test, s) == Approx(2e5));
  test.stages[0].swing = Swing::deviator;
  CHECK(stage_swing(test, s) == Approx(2e5 - 3.5e5));
  test.stages[0].swing = Swing::strain;
  CHECK(stage_swing(test, s) == Approx(1 - size / (5 * R)));
  test.stages[0].plane = {{0, 2}}, test.stages[0].strain_rate = -0.25;
  CHECK(stage_strain(test, s) == Approx(0.25 * 2));
  for (std::size_t k = 0; k < s.contacts.size(); ++k)  // of each contact along z 0.5 N along x
    if (std::abs(s.contacts.touch[k].normal.z()) > 0.9)
      s.contacts.touch[k].force.x() = 0.5 * s.contacts.touch[k].normal.z();
  // Half of eight forces times their branches, as the stress is symmetric.
  CHECK(stage_stress(test, s) == Approx(-0.5 * 8 * 0.5 * 0.5 * size / std::pow(size, 3)));
}

TEST_CASE("the unbalanced force is what grains feel over what contacts and bonds carry, each on average") {
  const Model own = grains();
  State s = lattice(own);
  for (auto& t : s.contacts.touch) t.force = Vec3(0, 3, 4);
  std::size_t links = 0;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) links += s.contacts.contact.touching(k);
  REQUIRE(links == 24);
  for (Vec3& f : s.grains.force) f = Vec3::Zero();
  s.grains.force[0] = Vec3(0, 0, 8), s.grains.force[1] = Vec3(0, -8, 0);
  CHECK(unbalanced_force(s) == Approx(16 / 8.0 / 5));
  CHECK(measure(own, s).unbalanced_force == Approx(16 / 8.0 / 5));
  CHECK(measure(own, s).contacts == 24);
  FaceBond bond{};
  bond.force = Vec3(29, 0, 0);
  s.bonds.face.row.push_back(bond);
  CHECK(unbalanced_force(s) == Approx(16 / 8.0 / ((24 * 5 + 29) / 25.0)));
  s.bonds.face.row.clear();
  std::fill(s.contacts.contact.stiffness.begin(), s.contacts.contact.stiffness.end(), 0.0);
  CHECK(unbalanced_force(s) == inf);
}

TEST_CASE("two axes of a box grow alike, of their present sizes, so that its volume stays") {
  const Model model = grains();
  State s;
  add_box(s, 1);
  add(s, PolyEllipsoid::sphere(0.1), Vec3::Constant(0.5), 2650);
  Team team(1);
  prepare(model, s, team);
  for (Wall& wall : s.boundary.walls)  // far walls: 1.2, 0.7 and 0.9 of a box that was 1
    for (int k = 0; k < 3; ++k)
      if (wall.facing()[k] == -1) wall.point[k] = std::array{1.2, 0.7, 0.9}[static_cast<std::size_t>(k)];
  const Vec3 size = size_of(s.boundary);
  for (int driven = 0; driven < 3; ++driven) {
    Loading loading;
    loading.driven = loading.isochoric = true, loading.initial_size = Vec3::Ones();
    loading.axes[static_cast<std::size_t>(driven)].strain_rate = -0.5;
    turn_loading(model, s, loading);
    Vec3 rate = Vec3::Zero();  // of the logarithm of each size
    for (const Wall& wall : s.boundary.walls)
      for (int k = 0; k < 3; ++k)
        if (wall.facing()[k] == -1) rate[k] = wall.velocity[k] / size[k];
    CHECK(rate[driven] == Approx(-0.5 / size[driven]).epsilon(1e-12));
    for (int k = 0; k < 3; ++k)
      if (k != driven) CHECK(rate[k] == Approx(-0.5 * rate[driven]).epsilon(1e-12));
  }
}
