// SPDX-License-Identifier: LGPL-3.0-or-later
// Which grains cleave, where, and what the parts get: gate, early exit, offsets, weakest plane, Y, crystals, dead
// loads.
#include "dem/bond/face_bond.hpp"
#include "dem/fracture/cleavage.hpp"
#include "dem/fracture/hull_loads.hpp"
#include "dem/rve/resting.hpp"
#include "tests/bonded.hpp"
#include "tests/held_grains.hpp"
#include "tests/loaded_body.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double flaw = 1e-2, toughness = 2e5;  // m, Pa m^1/2
const double strength = toughness / std::sqrt(pi * flaw);

using Loads = PointLoads;

Model cleaving(const Cleavage& c, bool cohesive = false) {
  Model model = rock(elastic(0.4), 0.5);
  FractureModel f;
  if (!c.planes.empty()) f.crystal = Crystal{Vec3::UnitZ(), {0.0}};
  f.criteria.emplace_back(c);
  f.splitter = Cut{cohesive, 50};
  model.materials[0].fracture = f;
  make_pair_laws(model);
  return model;
}

Cleavage along(std::vector<Cleavage::Plane> planes = {}) {
  Cleavage c;
  c.toughness = toughness, c.flaw = flaw, c.planes = std::move(planes);
  return c;
}

Cleft worst(const Cleavage& c, const Polyhedron& body, const Loads& loads) {
  const Model model = cleaving(c);
  const State s = loaded_body(model, body, loads);
  return std::get<Cleavage>(model.materials[0].fracture->criteria[0]).worst(loaded_hull(model, s, 0), 1);
}

/// On the faces of the unit cube: normal stresses.
Loads on_faces(const Vec3& stress) {
  Loads loads;
  for (int k = 0; k < 3; ++k)
    for (const double side : {-0.5, 0.5})
      loads.emplace_back(side * Vec3::Unit(k), 2 * side * stress[k] * Vec3::Unit(k));
  return loads;
}

Polyhedron prism() { return box_between(Vec3(-2, -0.5, -0.5), Vec3(2, 0.5, 0.5)); }

}  // namespace

TEST_CASE("the gate is on the mean stress: a grain in hydrostatic tension cleaves just above it, not just below") {
  Cleavage c = along();
  c.gate = 1.5 * strength;
  const Cleft below = worst(c, unit_cube(), on_faces(Vec3::Constant(0.99 * *c.gate)));
  CHECK(below.utilisation == 0);
  const Cleft above = worst(c, unit_cube(), on_faces(Vec3::Constant(1.01 * *c.gate)));
  CHECK(above.utilisation == Approx(1.01 * 1.5).epsilon(1e-6));
  // No stress along one axis, as much more along the others.
  CHECK(worst(c, unit_cube(), on_faces(Vec3(3.02, 0, 0) * *c.gate)).utilisation > 0);
  CHECK(worst(c, unit_cube(), on_faces(Vec3(2.98, 0, 0) * *c.gate)).utilisation == 0);
}

TEST_CASE("a grain without any tension is looked at for its shear: pressed along one axis, it fails at 45 degrees") {
  const double p = 2;
  const Cleft found = worst(along(), unit_cube(), on_faces(Vec3(0, 0, -p * strength)));
  CHECK(found.utilisation == Approx(0.5 * p / 0.816).epsilon(1e-6));
  CHECK(found.shear == Approx(0.5 * p * strength).epsilon(1e-6));
  CHECK(found.tension == 0);
  CHECK(std::abs(found.normal.z()) == Approx(std::sqrt(0.5)).epsilon(1e-6));
  const Cleft far = worst(along(), unit_cube(), on_faces(Vec3(0, 0, -0.2 * strength)));
  CHECK(far.normal == Vec3::Zero());  // far from failing: told by its stress alone
  CHECK(far.utilisation == Approx(0.1 / 0.816).epsilon(1e-6));
}

TEST_CASE("a slender grain is looked at for its bending, which its stress does not tell of") {
  Cleavage c = along({{Vec3::UnitX(), toughness}});
  c.offsets = {1e-9};
  const double f = strength / 36 * 1.5;  // of three points: 36 f of tension in the middle, at the rim
  const Cleft found = worst(c, prism(),
                            {{Vec3(0, 0.5, 0), Vec3(0, -6 * f, 0)},
                             {Vec3(2, -0.5, 0), Vec3(0, 3 * f, 0)},
                             {Vec3(-2, -0.5, 0), Vec3(0, 3 * f, 0)}});
  CHECK(found.tension == Approx(36 * f).epsilon(1e-6));
  CHECK(found.utilisation == Approx(mixed_mode(1.5, 3 * f / strength / 0.816)).epsilon(1e-6));
}

TEST_CASE("what twists a section shears it most at its corner") {
  Cleavage c = along({{Vec3::UnitX(), toughness}});
  const double f = 0.5 * strength;
  const Loads twist{{Vec3(2, 0, 0.5), Vec3(0, f, 0)},
                    {Vec3(2, 0, -0.5), Vec3(0, -f, 0)},
                    {Vec3(-2, 0, 0.5), Vec3(0, -f, 0)},
                    {Vec3(-2, 0, -0.5), Vec3(0, f, 0)}};
  const Cleft found = worst(c, prism(), twist);
  CHECK(found.shear == Approx(f * std::sqrt(0.5) * 6).epsilon(1e-6));  // moment f, corner, polar moment of the square
  CHECK(found.tension < 1e-6 * f);
}

TEST_CASE("offsets are of the reach on their own side, and planes of their own toughness") {
  // A tetrahedron on its base: its mass centre is a quarter of its height above that.
  const double h = 2;
  const Polyhedron body = hull_of(std::vector<Vec3>{{1, 0, 0}, {-0.5, 0.8, 0}, {-0.5, -0.8, 0}, {0, 0, h}});
  const Vec3 centre = moments_of(body).centre;
  const double pull = strength;
  const Loads loads{{Vec3(0, 0, h) - centre, Vec3(0, 0, pull)}, {Vec3(0, 0, 0) - centre, Vec3(0, 0, -pull)}};
  for (const double place : {-0.5, 0.5}) {
    Cleavage c = along({{Vec3::UnitZ(), toughness}});
    c.offsets = {place};
    CHECK(worst(c, body, loads).offset == Approx((place < 0 ? 0.25 : 0.75) * place * h).epsilon(1e-9));
  }
  for (const bool weak_first : {true, false}) {  // the early exit knows the weakest, wherever it stands
    std::vector<Cleavage::Plane> planes{{Vec3::UnitX(), 0.1 * toughness}, {Vec3::UnitY(), toughness}};
    if (!weak_first) std::swap(planes[0], planes[1]);
    const Cleft found = worst(along(planes), unit_cube(), on_faces(Vec3(0.15 * strength, 0.14 * strength, 0)));
    CHECK(found.utilisation == Approx(1.5).epsilon(1e-6));
    CHECK(std::abs(found.normal.x()) == Approx(1));
  }
}

TEST_CASE("Y, flaw, and the factor of a grain's strength: each as it should, in both modes") {
  for (const Vec3& stress : {Vec3(1, 0, 0), Vec3(0, 0, -2)}) {
    const double plain = worst(along(), unit_cube(), on_faces(strength * stress)).utilisation;
    Cleavage edge = along(), longer = along();
    edge.geometry = 1.12, longer.flaw = 4 * flaw;
    CHECK(worst(edge, unit_cube(), on_faces(strength * stress)).utilisation == Approx(1.12 * plain).epsilon(1e-9));
    CHECK(worst(longer, unit_cube(), on_faces(strength * stress)).utilisation == Approx(2 * plain).epsilon(1e-9));
  }
  CHECK(worst(along(), unit_cube(), on_faces(Vec3(strength, 0, 0))).utilisation == Approx(1).epsilon(1e-9));
}

TEST_CASE("the parts of a cut grain have its crystal in space, and the fresh face's area is booked") {
  Team team(1);
  for (const bool cohesive : {true, false}) {
    Cleavage c = along({{Vec3::UnitX(), toughness}});
    const Model model = cleaving(c, cohesive);
    State s;
    add_body(
        s,
        hull_of(std::vector<Vec3>{{1.2, 0, 0}, {-1, 0, 0}, {0, 0.7, 0.2}, {0, -0.8, 0}, {0.1, 0, 0.9}, {0, 0.1, -0.5}}),
        Vec3(1, 2, 3), random_rotation(5, 1));
    prepare(model, s, team);
    const auto axes = [&](std::size_t i) {
      return LoadedHull{model.law, 0.2, s.grains, s.boundary, s.contacts, s.bonds, s.break_room.bonds, i}
          .crystal_axes();
    };
    const Mat3 before = axes(0);
    apply_breaks(model, s, {{0, {Mat3::Zero(), Vec3(0.6, 0, 0.8), Vec3::Zero(), 0.1}}}, team);
    REQUIRE(s.grains.size() == 2);
    for (const std::size_t i : {0u, 1u}) CHECK((axes(i) - before).norm() < 1e-12);

    State bar = loaded_body(model, prism(), {});
    apply_breaks(model, bar, {{0, {Mat3::Zero(), Vec3(0.6, 0.8, 0)}}}, team);
    REQUIRE(bar.grains.size() == 2);
    // Across the bar at a slope of 4 : 3: the square's area over the cosine - its corners lie within the bar.
    CHECK(bar.ledger.fracture_area == Approx(1 / 0.6).epsilon(1e-9));
    CHECK(bar.bonds.size() == (cohesive ? 1 : 0));
  }
}

TEST_CASE("a dead load stays at its point, on the part that has it") {
  Team team(1);
  const Model model = cleaving(along());
  const Loads loads{
      {Vec3(2, 0.25, 0), Vec3(0, 0, -7)}, {Vec3(-2, 0, 0.1), Vec3(0, 3, 0)}, {Vec3(0.4, 0.5, 0), Vec3(1, 0, 0)}};
  for (const double side : {1.0, -1.0}) {
    State s = loaded_body(model, prism(), loads);
    apply_breaks(model, s, {{0, {Mat3::Zero(), side * Vec3::UnitX(), Vec3::Zero(), side * 0.3}}}, team);
    REQUIRE(s.grains.size() == 2);
    REQUIRE(s.bonds.load.size() == 3);
    for (std::size_t k = 0; k < 3; ++k) {
      const DeadLoad& load = s.bonds.load[k];
      const Motion& of = s.grains.motion[load.grain];
      CHECK((of.position + s.grains.orientation[load.grain] * load.at - loads[k].first).norm() < 1e-9);
      CHECK((of.position.x() > 0.3) == (loads[k].first.x() > 0.3));
    }
    s.dt = 1e-12;
    run_steps(model, s, 1, team);
    for (std::size_t i = 0; i < 2; ++i) {
      Vec3 force = Vec3::Zero();
      for (const auto& [at, load] : loads)
        if ((at.x() > 0.3) == (s.grains.motion[i].position.x() > 0.3)) force += load;
      CHECK((s.grains.force[i] - force).norm() < 1e-9);
    }
  }
}

TEST_CASE("grains that have rested cleave where they would have") {
  Team team(1);
  Model model = cleaving(along());
  model.materials[0].bond.reset();
  std::get<Cleavage>(model.materials[0].fracture->criteria[0]).toughness = 1e30;
  State s = deforming_cube(model, 20, 15, team);
  run_steps(model, s, 60, team);
  State rested = resting_copy(s);
  awaken(model, rested, team);
  Cleavage weak = along();
  weak.toughness = 1;
  double most = 0;
  for (State* state : {&s, &rested}) {
    index_grains(state->grains.size(), state->contacts, state->reference.room.next);
    index_bonds(state->grains.size(), state->bonds, state->break_room.bonds);
  }
  for (std::size_t i = 0; i < s.grains.size(); ++i) {
    const auto of = [&](const State& now) {
      return weak.worst({model.law, 0.2, now.grains, now.boundary, now.contacts, now.bonds, now.break_room.bonds, i},
                        1);
    };
    const Cleft before = of(s), after = of(rested);
    most = std::max(most, before.utilisation);
    CHECK(after.utilisation == Approx(before.utilisation).epsilon(1e-6));
    CHECK((after.normal - before.normal).norm() < 1e-6);
  }
  CHECK(most > 1);
}
