// SPDX-License-Identifier: LGPL-3.0-or-later
// Grains that move with walls: what lies on them presses with its weight, their motion and no more is work, they keep
// their places and orientations, whatever their shape; a rough lid holds its stress; same bits.
#include "dem/rve/rough_walls.hpp"
#include "dem/io/archive.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/press.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/rve/wall_force.hpp"
#include "dem/sample/gauge.hpp"
#include "dem/sample/make.hpp"
#include "dem/sample/stages.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr std::uint8_t fixed_one = 2;  // material
constexpr double stiffness = 1e5;      // N/m, of every contact

/// Materials: 0 the grains', 1 rigid walls, 2 grains that move with walls.
Model with_fixed(Model model, double damping) {
  Material fixed = model.materials[0];
  fixed.fixed = true;
  model.materials.push_back(fixed);
  make_pair_laws(model);
  set_damping(model, damping);
  return model;
}

Model springs(double friction, double damping, double restitution = 1) {
  Model model = linear_model(stiffness, 1, 2650, friction);
  model.materials[0].restitution = restitution;
  return with_fixed(model, damping);
}

std::size_t add_fixed(State& s, std::size_t i, std::size_t wall) {
  s.grains.material[i] = fixed_one;
  s.boundary.walls[wall].grains = {fixed_one};
  fix(s.grains, i, s.boundary.walls[wall].velocity);
  return i;
}

std::size_t add_ball(State& s, double radius, const Vec3& x) { return add(s, PolyEllipsoid::sphere(radius), x, 2650); }

void let_run(const Model& model, State& s, double time, Team& team) {
  Loading free;
  begin_loading(model, s, free);
  load(model, s, free, s.time + time, team);
}

/// Three fixed spheres of 1 mm that touch one another on a floor, which they lie in with a tenth of theirs.
State three_on_a_floor() {
  State s;
  add_floor(s);
  for (int k = 0; k < 3; ++k) {
    const double angle = 2 * pi * k / 3, arm = 2e-3 / std::sqrt(3.0);
    add_fixed(s, add_ball(s, 1e-3, Vec3(arm * std::cos(angle), arm * std::sin(angle), 0.9e-3)), 0);
  }
  return s;
}

/// A box of spheres, those within 1.5 mm of the floor and of the lid fixed to them.
State rough_box(const Model& model, Team& team, const Vec3& way_of_lid) {
  State s;
  const Packing p = random_packing(Vec3::Constant(8e-3), {"uniform", 1e-3, 0, 0.8e-3, 1.2e-3}, 0.53, 0, false, 1);
  for (const auto& sphere : p.spheres) add_ball(s, sphere.radius, sphere.position);
  add_box(s, 8e-3);
  s.boundary.walls[5].velocity = way_of_lid;
  s.boundary.walls[4].grains = {fixed_one}, s.boundary.walls[5].grains = {3};
  for (std::size_t i = 0; i < s.grains.size(); ++i)
    for (const std::size_t w : {4u, 5u})
      if (s.boundary.walls[w].distance(s.grains.motion[i].position) < 1.5e-3) {
        s.grains.material[i] = s.boundary.walls[w].grains[0];
        fix(s.grains, i, s.boundary.walls[w].velocity);
      }
  prepare(model, s, team);
  return s;
}

Model sand() {
  Model model = with_fixed(model_of(solid(10e9, 0.2, 2650, 0.5, 0.5)), 0);
  model.materials.push_back(model.materials[fixed_one]);
  make_pair_laws(model);
  set_damping(model, 0.2);
  return model;
}

}  // namespace

TEST_CASE("a sphere in the hollow of three fixed ones: weight, contact forces and height in closed form") {
  Model model = springs(0, 0.5, 0.3);
  model.motion.gravity = Vec3(0, 0, -9.81);
  Team team(1);
  State s = three_on_a_floor();
  const std::size_t top = add_ball(s, 1e-3, Vec3(0, 0, 0.9e-3 + 2e-3 * std::sqrt(2.0 / 3)));
  prepare(model, s, team);
  CHECK(s.contacts.size() == 3);  // fixed grains meet neither one another nor the floor
  let_run(model, s, 0.05, team);
  const double weight = s.grains.mass[top] * 9.81, one = weight / std::sqrt(6.0);  // of three, cos = sqrt(2/3)
  const Vec3 force = wall_force(s, 0);
  CHECK(force.z() == Approx(-weight).epsilon(1e-6));
  CHECK(force.head<2>().norm() < 1e-6 * weight);
  const Measurement m = measure(model, s);
  CHECK(m.elastic == Approx(3 * 0.5 * one * one / stiffness).epsilon(1e-5));
  const double apart = 2e-3 - one / stiffness;  // of the centres; the hollow is 2 / sqrt(3) mm from each
  CHECK(s.grains.motion[top].position.z() - 0.9e-3 == Approx(std::sqrt(apart * apart - 4e-6 / 3)).epsilon(1e-9));
  CHECK(m.unbalanced_force < 1e-4);  // of the free one alone
  CHECK(unbalanced_force(s) == Approx(m.unbalanced_force).margin(1e-12));
  CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 2e-3);
}

TEST_CASE("unbalanced force is of the free grains: one that falls apart from its weight on fixed ones") {
  Model model = springs(0, 0);
  model.motion.gravity = Vec3(0, 0, -9.81);
  Team team(1);
  State s = three_on_a_floor();
  const std::size_t top = add_ball(s, 1e-3, Vec3(0, 0, 0.9e-3 + 2e-3 * std::sqrt(2.0 / 3) - 1e-6));
  prepare(model, s, team);
  double force = 0;
  for (std::size_t k = 0; k < 3; ++k) force += s.contacts.touch[k].force.norm() / 3;
  const double left = s.grains.force[top].norm() / force;
  CHECK(left > 0.1);
  CHECK(measure(model, s).unbalanced_force == Approx(left).epsilon(1e-12));
  CHECK(unbalanced_force(s) == Approx(left).epsilon(1e-12));
}

TEST_CASE("a rough wall that moves does work on free grains, and none for its own weight or with damping") {
  Model model = springs(0.5, 0.3);
  model.motion.gravity = Vec3(1, 0, -9.81);
  Team team(1);
  State s = three_on_a_floor();
  s.boundary.walls[0].velocity = Vec3(0.02, 0, 0.05);
  const std::size_t far = add_ball(s, 1e-3, Vec3(0, 0, 50e-3));
  prepare(model, s, team);
  const Vec3 from = s.grains.motion[far].position;
  let_run(model, s, 5e-3, team);
  const double fell = (s.grains.motion[far].position - from).dot(model.motion.gravity) * s.grains.mass[far];
  CHECK(s.ledger.work == Approx(fell).epsilon(1e-6));
  CHECK(s.ledger.damping == Approx(0.3 * fell).epsilon(1e-3));  // of the free one: against its motion with g
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(s.grains.motion[i].velocity == s.boundary.walls[0].velocity);
    CHECK(s.grains.motion[i].position.z() - 0.9e-3 == Approx(0.05 * 5e-3).epsilon(1e-12));
  }
}

TEST_CASE("a fixed sphere that is pressed on a free one: force, work and energy are those of two springs in a row") {
  Model model = springs(0, 0);
  Team team(1);
  State s;
  add_floor(s);
  s.boundary.walls.push_back(
      {.point = Vec3(0, 0, 4.5e-3), .shape = PlaneWall{-Vec3::UnitZ()}, .velocity = Vec3(0, 0, -1e-3), .material = 1});
  add_ball(s, 1e-3, Vec3(0, 0, 1e-3));
  add_fixed(s, add_ball(s, 1e-3, Vec3(0, 0, 3e-3)), 1);
  prepare(model, s, team);
  let_run(model, s, 0.02, team);  // 20 um, so slowly that the free one hardly swings
  const double way = 20e-6, both = stiffness / 2;
  CHECK(wall_force(s, 1).z() == Approx(both * way).epsilon(2e-3));
  CHECK(wall_force(s, 0).z() == Approx(-both * way).epsilon(2e-3));
  CHECK(s.ledger.work == Approx(0.5 * both * way * way).epsilon(2e-3));
  CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 1e-4);
}

TEST_CASE("a rough wall that gets another velocity takes its grains along, and their kinetic energy is work") {
  const Model model = springs(0, 0);
  State s = three_on_a_floor();
  s.boundary.walls[0].velocity = Vec3(0.3, 0, 0);
  carry_rough_walls(s);
  const double mass = 3 * s.grains.mass[0];
  CHECK(s.ledger.work == Approx(0.5 * mass * 0.09).epsilon(1e-12));
  CHECK(kinetic_energy(s.grains) == Approx(s.ledger.work).epsilon(1e-12));
  s.boundary.walls[0].velocity = Vec3::Zero();
  carry_rough_walls(s);
  CHECK(std::abs(s.ledger.work) < 1e-12 * mass);
}

TEST_CASE("fixed ellipsoids and blocks keep their orientation: what hits them bounces as off a wall") {
  Team team(1);
  for (const bool block : {false, true}) {
    INFO(block);
    State s;
    Model model = block ? with_fixed(hull_model(), 0) : springs(0, 0);
    model.numerics.safety = 0.02;  // some hundred steps an impact
    add_floor(s);
    std::size_t low = 0, high = 0;
    if (block) {
      low = add_body(s, unit_cube(), Vec3(0.3, 0.1, 0.5), Quat::Identity());
      high = add_body(s, unit_cube(), Vec3(0, 0, 1.501), Quat::Identity(), Vec3(0, 0, -0.1));
    } else {
      PolyEllipsoid flat;
      flat.plus = flat.minus = Vec3(2e-3, 1e-3, 0.5e-3);
      low = add(s, flat, Vec3(0, 0, 0.5e-3), 2650);
      high = add_ball(s, 1e-3, Vec3(1e-3, 0.2e-3, 2.2e-3));
      s.grains.motion[high].velocity = Vec3(0, 0, -0.1);
    }
    add_fixed(s, low, 0);
    const Quat before = s.grains.orientation[low];
    prepare(model, s, team);
    const double kinetic = kinetic_energy(s.grains);
    run_for(model, s, block ? 0.5 : 0.02, team);
    CHECK(measure(model, s).contacts == 0);
    CHECK(kinetic_energy(s.grains) == Approx(kinetic).epsilon(2e-3));
    CHECK(s.grains.motion[high].velocity.z() > 0);
    CHECK(s.grains.orientation[low].coeffs() == before.coeffs());
    CHECK(s.grains.motion[low].spin.norm() < 1e-100);
    CHECK(s.grains.motion[low].velocity.isZero(0));
  }
}

TEST_CASE("a rough lid that goes along keeps its stress, energy and bits; the floor bears what the lid presses") {
  const Model model = sand();
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 3}) {
    Team team(threads);
    State s = rough_box(model, team, Vec3(0.1, 0, 0));
    Loading l;
    l.walls = {{.wall = 5, .stress = 3e5}};
    begin_loading(model, s, l);
    load(model, s, l, 3e-3, team);
    if (threads == 3) s = state_of(bytes_of(s));  // goes on from a checkpoint
    load(model, s, l, 6e-3, team);
    const WallForce found = force_of(s, l.walls[0]);
    CHECK(found.force == Approx(found.asked).epsilon(2e-3));
    CHECK(wall_force(s, 5).z() == Approx(found.force).epsilon(1e-12));
    Vec3 sum = Vec3::Zero();
    for (std::size_t w = 0; w < 6; ++w) sum += wall_force(s, w);
    CHECK(sum.norm() < 0.05 * found.force);
    CHECK(wall_force(s, 5).x() < -0.05 * found.force);
    CHECK(-measure(model, s).wall_stress(2, 2) ==
          Approx(0.5 * (found.force - wall_force(s, 4).z()) / 64e-6).epsilon(1e-9));
    CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 5e-3);
    CHECK(s.ledger.work > 0);
    hashes.push_back(hash(s));
  }
  CHECK(hashes[0] == hashes[1]);
}

TEST_CASE("a lid whose grains press seeks its stress by their stiffness: of contacts in line and aslant") {
  const Model model = springs(0, 0.2, 0.5);
  Team team(1);
  State s;
  add_floor(s);
  s.boundary.walls.push_back({.point = Vec3(0, 0, 4.5e-3), .shape = PlaneWall{-Vec3::UnitZ()}, .material = 1});
  add_ball(s, 1e-3, Vec3(0, 0, 1e-3));
  add_fixed(s, add_ball(s, 1e-3, Vec3(0, 0, 3.02e-3)), 1);
  prepare(model, s, team);
  Loading l;
  l.walls = {{.wall = 1, .stress = 2e5, .area = 4e-6}};
  begin_loading(model, s, l);
  load(model, s, l, 10e-3, team);
  CHECK(force_of(s, l.walls[0]).force == Approx(0.8).epsilon(1e-3));
  CHECK(s.boundary.walls[1].point.z() == Approx(4.5e-3 - 0.02e-3 - 2 * 0.8 / stiffness).epsilon(1e-6));
  CHECK(s.grains.motion[1].position.z() == Approx(s.boundary.walls[1].point.z() - 1.48e-3).epsilon(1e-12));
  CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 1e-3);
}

TEST_CASE("walls that press on all sides of a box bear the weight of free grains alone") {
  Model model = sand();
  model.motion.gravity = Vec3(0, 0, -2000);
  Team team(1);
  State s = rough_box(model, team, Vec3::Zero());
  double free = 0;
  for (std::size_t i = 0; i < s.grains.size(); ++i)
    if (s.grains.motion[i].inverse_mass > 0) free += s.grains.mass[i];
  Loading l;
  l.driven = l.holds = true;
  for (auto& axis : l.axes) axis = {0, -5e5, 50};
  begin_loading(model, s, l);
  load(model, s, l, 8e-3, team);
  const double low = -wall_force(s, 4).z(), high = wall_force(s, 5).z();
  CHECK(low - high == Approx(2000 * free).epsilon(0.02));
  CHECK(-measure(model, s).wall_stress(2, 2) == Approx(5e5).epsilon(5e-3));
}

TEST_CASE("Love and Weber's stress between rough walls is the walls'") {
  Model model = springs(0, 0);
  Material other = model.materials[fixed_one];
  model.materials.push_back(other);
  make_pair_laws(model);
  const double r = 1e-3;
  Team team(1);
  State s;  // a column of four spheres, the lowest and the highest fixed: a cell wide, between floor and lid
  for (int k = 0; k < 4; ++k) add_ball(s, r, Vec3(3 * r, 3 * r, r * (1 + 1.995 * k)));
  s.boundary.cell = walled_cell(Vec3(6 * r, 6 * r, 8 * r), r);
  add_floor(s);
  s.boundary.walls.push_back({.point = Vec3(0, 0, 8 * r), .shape = PlaneWall{-Vec3::UnitZ()}, .material = 1});
  for (const std::size_t w : {0u, 1u}) {
    const std::size_t i = w == 0 ? 0 : 3;
    s.grains.material[i] = static_cast<std::uint8_t>(fixed_one + w);
    s.boundary.walls[w].grains = {s.grains.material[i]};
    fix(s.grains, i, Vec3::Zero());
  }
  prepare(model, s, team);
  const Measurement m = measure(model, s);
  CHECK(-m.wall_stress(2, 2) == Approx(stiffness * 5e-6 / (36 * r * r)).epsilon(1e-9));
  CHECK(m.stress(2, 2) == Approx(m.wall_stress(2, 2)).epsilon(1e-9));
}

TEST_CASE("each wall takes the grains of its own layer and material, and what no wall takes stays free") {
  Model model = model_of(solid(10e9, 0.2, 2650, 0.5, 0.5));
  for (int k = 0; k < 3; ++k) {  // 2: another one of grains; 3 and 4 are of those that move with floor and lid
    model.materials.push_back(model.materials[0]);
    model.materials.back().fixed = k > 0;
  }
  make_pair_laws(model);
  Recipe recipe;
  recipe.bounds = Bounds::walls, recipe.box = Vec3::Constant(6e-3), recipe.wall_material = 1;
  RandomPacking p;
  p.radius = {"constant", 0.5e-3}, p.solid_fraction = 0.4;
  p.parts = {{.material = 0, .share = 0.5}, {.material = 2, .share = 0.5}};
  recipe.grains = p;
  recipe.sides = {{.name = "zmax", .velocity = Vec3(0.1, 0, 0)}};
  recipe.rough = {{.wall = 4, .within = 1e-3, .of = {}, .becomes = {3, 1, 3}},
                  {.wall = 5, .within = 1.5e-3, .of = 2, .becomes = {0, 1, 4, 3}}};
  Team team(1);
  const Sample sample = make(model, recipe, team);
  const State& s = sample.state;
  CHECK(s.boundary.walls[4].grains == std::vector<std::uint8_t>{3});
  CHECK(s.boundary.walls[5].grains == std::vector<std::uint8_t>{4});
  std::size_t low = 0, high = 0;
  for (std::size_t i = 0; i < s.grains.size(); ++i) {
    const double z = s.grains.motion[i].position.z();
    const std::uint8_t material = s.grains.material[i];
    low += material == 3, high += material == 4;
    CHECK((material == 3) == (z <= 1e-3));
    CHECK((material != 4 || z >= 4.5e-3));
    CHECK((material != 2 || (z > 1e-3 && z < 4.5e-3)));
    CHECK((s.grains.motion[i].inverse_mass == 0) == (material >= 3));
    CHECK(s.grains.motion[i].velocity.x() == (material == 4 ? 0.1 : 0));
  }
  CHECK((low > 0 && high > 0));
  CHECK(sample.notes.size() == 2);
  recipe.rough[0].within = 1e-4;
  CHECK_THROWS_WITH(make(model, recipe, team), Catch::Contains("no grain is there to move with this wall"));
  recipe.rough = {{.wall = 4, .within = 1, .of = {}, .becomes = {3, 1, 3}}};
  CHECK_THROWS_WITH(make(model, recipe, team), Catch::Contains("all grains move with walls"));
  recipe.rough.push_back({.wall = 5, .within = 1, .of = {}, .becomes = {3, 1, 3}});  // finds none: the first took all
  recipe.rough[0].place = "wall[0].fixed_layer";
  CHECK_THROWS_WITH(make(model, recipe, team), Catch::StartsWith("wall[0].fixed_layer: all grains move with walls"));
}
