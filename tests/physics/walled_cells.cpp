// SPDX-License-Identifier: LGPL-3.0-or-later
// Cells that are periodic along x and y between walls across z: weight, columns and layers in closed form, momentum,
// what shear of a layer takes, lids that go far; same bits.
#include "dem/io/archive.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/press.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/rve/wall_force.hpp"
#include "dem/sample/gauge.hpp"
#include "dem/sample/make.hpp"
#include "dem/sample/prepare.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double stiffness = 1e5;  // N/m, of every contact

Model springs(double friction, double damping, double restitution = 1) {
  Model model = linear_model(stiffness, 1, 2650, friction);
  model.materials[0].restitution = restitution;
  set_damping(model, damping);
  make_pair_laws(model);
  return model;
}

State between_walls(const Vec3& box, const std::vector<Sphere>& spheres) {
  State s;
  double largest = 0;
  for (const Sphere& ball : spheres) {
    add(s, PolyEllipsoid::sphere(ball.radius), ball.position, 2650);
    largest = std::max(largest, ball.radius);
  }
  s.boundary.cell = walled_cell(box, largest);
  add_floor(s);
  s.boundary.walls.push_back({.point = Vec3(0, 0, box.z()), .shape = PlaneWall{-Vec3::UnitZ()}, .material = 1});
  return s;
}

void let_run(const Model& model, State& s, double time, Team& team) {
  Loading free;
  begin_loading(model, s, free);
  load(model, s, free, s.time + time, team);
}

Recipe random_recipe(double fraction) {
  Recipe recipe;
  recipe.bounds = Bounds::periodic_xy, recipe.box = Vec3(6e-3, 5e-3, 7e-3), recipe.wall_material = 1;
  RandomPacking p;
  p.radius = {"uniform", 0.4e-3, 0, 0.3e-3, 0.5e-3};
  p.solid_fraction = fraction;
  recipe.grains = p;
  return recipe;
}

}  // namespace

TEST_CASE("a hexagonal packing stands on its floor: the weight, and what each layer holds") {
  Model model = springs(0, 0.5, 0.3);
  model.motion.gravity = Vec3(0, 0, -9.81);
  const double r = 1e-3;
  const int layers = 5;
  Team team(1);
  const Packing p = hexagonal_close(r, {4, 4, layers});
  State s = between_walls(Vec3(8 * r, 4 * std::sqrt(3.0) * r, p.box.z() + r), p.spheres);
  prepare(model, s, team);
  let_run(model, s, 0.05, team);
  const double one = s.grains.mass[0] * 9.81, all = one * 16 * layers;
  CHECK(wall_force(s, 0).z() == Approx(-all).epsilon(1e-5));
  CHECK(wall_force(s, 0).head<2>().norm() < 1e-6 * all);
  CHECK(wall_force(s, 1).isZero(0));
  double energy = 16 * 0.5 * std::pow(layers * one, 2) / stiffness;  // of the floor; three contacts to the layer above
  for (int above = 1; above < layers; ++above)
    energy += 16 * 3 * 0.5 * std::pow(above * one / (3 * std::sqrt(2.0 / 3)), 2) / stiffness;
  CHECK(measure(model, s).elastic == Approx(energy).epsilon(1e-3));
  CHECK(bulk_volume(s.boundary) == Approx(8 * r * 4 * std::sqrt(3.0) * r * (p.box.z() + r)).epsilon(1e-12));
  CHECK(-measure(model, s).wall_stress(2, 2) == Approx(0.5 * all / (32 * std::sqrt(3.0) * r * r)).epsilon(1e-5));
}

TEST_CASE("columns of spheres under a lid: stress and strain in closed form, along z alone") {
  const Model model = springs(0, 0.3, 0.5);
  const double r = 1e-3;
  Team team(1);
  const Packing p = simple_cubic(r, {3, 2, 4});
  const Vec3 box = p.box - Vec3(3 * 2e-6, 0, 0);  // rows of three along x are pressed, and stay so
  State s = between_walls(box, p.spheres);
  prepare(model, s, team);
  Loading l;
  l.driven = true, l.axes[2].strain_rate = -0.1;
  begin_loading(model, s, l);
  CHECK(size_of(s.boundary) == box);
  load(model, s, l, 0.01, team);
  const double way = 1e-3 * box.z(), compliance = 5 / stiffness;
  const double stress = way / compliance / (4 * r * r);
  CHECK(displacement_gradient(s, l, s.boundary.cell.vectors)(2, 2) == Approx(-1e-3).epsilon(1e-9));
  CHECK(displacement_gradient(s, l, s.boundary.cell.vectors)(0, 0) == 0);
  const Measurement m = measure(model, s);
  CHECK(-m.wall_stress(2, 2) == Approx(stress).epsilon(5e-3));
  CHECK(-m.stress(2, 2) == Approx(stress * box.z() / (box.z() - way)).epsilon(6e-3));
  const double row = stiffness * 2e-6 / (4 * r * r) * box.z() / (box.z() - way);
  CHECK(-m.wall_stress(0, 0) == Approx(row).epsilon(1e-2));
  CHECK(std::abs(m.wall_stress(1, 1)) < 1e-6 * stress);
  Programme test;
  test.kind = TestKind::uniaxial_strain, test.loading = l;
  CHECK(axial_stress(test, s, s, m) == Approx(stress).epsilon(5e-3));
  test.axis = 0;
  CHECK(axial_stress(test, s, s, m) == -m.stress(0, 0));  // nothing faces along x
}

TEST_CASE("grains that fly about keep their momentum along x and y, and meet one another through the sides") {
  const Model model = springs(0, 0);
  Team team(1);
  State s = make(model, random_recipe(0.2), team).state;
  for (std::size_t i = 0; i < s.grains.size(); ++i)
    for (int k = 0; k < 3; ++k)
      s.grains.motion[i].velocity[k] = random_normal(3, i, Purpose::position, static_cast<std::uint64_t>(k));
  prepare(model, s, team);
  const Vec3 before = momentum(s.grains);
  const double kinetic = kinetic_energy(s.grains);
  let_run(model, s, 0.01, team);
  const Vec3 after = momentum(s.grains);
  const double all = std::sqrt(2 * total_mass(s.grains) * kinetic);
  CHECK((after - before).head<2>().norm() < 1e-12 * all);
  CHECK(std::abs(after.z() - before.z()) > 1e-3 * all);
  bool across = false;
  for (const Pair& pair : s.contacts.pair) across = across || crosses(pair);
  CHECK(across);
  for (const Pair& pair : s.contacts.pair) CHECK(pair.image[2] == 0);
  CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 1e-3);
}

TEST_CASE("nothing changes where a sample is moved along x and y: its sides are nowhere") {
  const Model model = springs(0.3, 0);
  Team team(1);
  State s = make(model, random_recipe(0.58), team).state;
  s.boundary.walls[1].point.z() -= 0.05e-3;  // presses
  State moved = s;
  for (Motion& m : moved.grains.motion) m.position += Vec3(2.3e-3, -7.7e-3, 0);
  prepare(model, s, team), prepare(model, moved, team);
  CHECK(wall_force(s, 1).z() > 0);
  CHECK(wall_force(moved, 1).z() == Approx(wall_force(s, 1).z()).epsilon(1e-9));
  const Measurement a = measure(model, s), b = measure(model, moved);
  CHECK((a.stress - b.stress).norm() < 1e-9 * a.stress.norm());
  CHECK(a.contacts == b.contacts);
}

TEST_CASE("a random packing between walls has its solid fraction, and lies in nothing") {
  const Model model = springs(0, 0);
  Team team(1);
  const Recipe recipe = random_recipe(0.6);
  const Sample sample = make(model, recipe, team);
  const State& s = sample.state;
  CHECK(solid_volume(s.grains) / recipe.box.prod() == Approx(0.6).epsilon(1e-9));
  CHECK(bulk_volume(s.boundary) == Approx(recipe.box.prod()).epsilon(1e-12));
  double outside = 0;
  for (const Motion& m : s.grains.motion) {
    CHECK(std::min(m.position.z(), recipe.box.z() - m.position.z()) > m.radius * (1 - 1e-5));
    outside = std::max({outside, m.radius - m.position.x(), m.position.x() + m.radius - recipe.box.x()});
  }
  CHECK(outside > 0);  // no wall along x
  double deepest = 0;
  for (std::size_t i = 0; i < s.grains.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      Vec3 d = s.grains.motion[i].position - s.grains.motion[j].position;
      for (int k = 0; k < 2; ++k) d[k] -= recipe.box[k] * std::round(d[k] / recipe.box[k]);
      deepest = std::max(deepest, s.grains.motion[i].radius + s.grains.motion[j].radius - d.norm());
    }
  CHECK(deepest < 1e-5 * 0.5e-3);
}

TEST_CASE("a layer that sticks to a lid and slides on the floor: its friction, the work, and forces that balance") {
  Model model = springs(0.6, 0, 0.3);
  model.materials[0].turns = false;
  Material floor = model.materials[1];
  floor.friction = 0.25;
  model.materials.push_back(floor);
  make_pair_laws(model);
  const double r = 1e-3, speed = 0.02, normal = 4 * 4 * r * r * 1e5;  // four spheres
  Team team(1);
  const Packing p = simple_cubic(r, {2, 2, 1});
  State s = between_walls(Vec3(5 * r, 5 * r, 2 * r), p.spheres);
  for (Motion& m : s.grains.motion) m.inverse_inertia = 0;
  s.boundary.walls[0].material = 2;
  s.boundary.walls[1].velocity = Vec3(speed, 0, 0);
  prepare(model, s, team);
  Loading l;
  l.walls = {{.wall = 1, .stress = 1e5, .area = 16 * r * r}};
  begin_loading(model, s, l);
  load(model, s, l, 10e-3, team);
  const double rubbed = s.ledger.friction, at = s.grains.motion[0].position.x();
  double lid = 0, low = 0, stress = 0;
  constexpr int looks = 1000;  // the layer swings on the springs that hold it to the lid
  for (int k = 0; k < looks; ++k) {
    load(model, s, l, s.time + 7.3e-6, team);
    lid += wall_force(s, 1).x() / looks, low += wall_force(s, 0).x() / looks;
    stress += measure(model, s).stress(0, 2) / looks;
  }
  CHECK(wall_force(s, 1).z() == Approx(normal).epsilon(1e-3));
  CHECK(lid == Approx(-0.25 * normal).epsilon(1e-2));
  CHECK(low == Approx(0.25 * normal).epsilon(2e-3));
  // Half of it is along the other axis, where grains that do not turn carry none.
  CHECK(stress == Approx(0.5 * 0.25 * normal / (25 * r * r)).epsilon(1e-2));
  load(model, s, l, 0.61, team);  // more than two cells along
  const double way = speed * 0.6;
  CHECK(s.grains.motion[0].position.x() - at == Approx(way).epsilon(1e-4));
  CHECK(s.ledger.friction - rubbed == Approx(0.25 * normal * way).epsilon(2e-3));
  CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 1e-3);
}

TEST_CASE("a lid that goes far away: what flies after it meets no image of what lies on the floor") {
  const Model model = springs(0, 0);
  const double r = 1e-3;
  Team team(1);
  State s = between_walls(Vec3(5 * r, 5 * r, 5 * r), {{Vec3(2 * r, 2 * r, r), r}, {Vec3(2 * r, 2 * r, 3.5 * r), r}});
  s.boundary.walls[1].velocity = Vec3(0, 0, 3);
  s.grains.motion[1].velocity = Vec3(0, 0, 2);
  const double edge = s.boundary.cell.vectors(2, 2);
  prepare(model, s, team);
  let_run(model, s, 4 * edge / 2, team);
  CHECK(s.grains.motion[1].velocity == Vec3(0, 0, 2));
  CHECK(s.grains.motion[0].velocity.isZero(0));
  CHECK(s.grains.motion[1].position.z() > 4 * edge);
  CHECK(s.boundary.cell.vectors(2, 2) > s.boundary.walls[1].point.z() + 2 * r);
  CHECK(s.boundary.cell.vectors(0, 0) == 5 * r);
  const double volume = 25 * r * r * s.boundary.walls[1].point.z();
  CHECK(measure(model, s).volume == Approx(volume).epsilon(1e-12));
}

TEST_CASE("a sample that is pressed and sheared: the same bits on any threads, and from a checkpoint on") {
  Model model = model_of(solid(10e9, 0.2, 2650, 0.5, 0.5));
  set_damping(model, 0.2);
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 3}) {
    Team team(threads);
    State s = make(model, random_recipe(0.58), team).state;
    s.boundary.walls[1].velocity = Vec3(0.1, 0.02, 0);
    prepare(model, s, team);
    Loading l;
    l.walls = {{.wall = 1, .stress = 2e5}};
    begin_loading(model, s, l);
    load(model, s, l, 1e-3, team);
    if (threads == 3) s = state_of(bytes_of(s));
    load(model, s, l, 3e-3, team);
    const WallForce found = force_of(s, l.walls[0]);
    CHECK(found.asked == Approx(2e5 * 30e-6).epsilon(1e-12));
    CHECK(found.force == Approx(found.asked).epsilon(2e-3));
    CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 5e-3);
    hashes.push_back(hash(s));
  }
  CHECK(hashes[0] == hashes[1]);
}
