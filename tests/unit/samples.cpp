// SPDX-License-Identifier: LGPL-3.0-or-later
// Recipes and what becomes of them; the gauge of a test; networks of faces.
#include <fstream>

#include "dem/io/frames.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/rve/wall_force.hpp"
#include "dem/sample/gauge.hpp"
#include "dem/sample/network.hpp"
#include "dem/sample/prepare.hpp"
#include "tests/apps/scratch.hpp"
#include "tests/bonded.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 1e-3;

/// Hertz's force (N) of a sphere of radius R and `material` pressed against a rigid plane by a depth.
double hertz(const Material& m, double depth) {
  const double E = m.youngs_modulus / (1 - m.poissons_ratio * m.poissons_ratio);
  return 4.0 / 3 * E * std::sqrt(R) * std::pow(depth, 1.5);
}

Recipe two_spheres() {
  Recipe recipe;
  Listed grains(2);
  for (int k = 0; k < 2; ++k)
    grains[static_cast<std::size_t>(k)].spec.shape = PolyEllipsoid::sphere(R),
    grains[static_cast<std::size_t>(k)].spec.position = Vec3(5 * R * k, 0, 0);
  recipe.grains = grains;
  return recipe;
}

Recipe tessellation(Bounds bounds, const Vec3& box, std::size_t cells) {
  Recipe recipe;
  recipe.bounds = bounds, recipe.box = box, recipe.wall_material = 1;
  recipe.grains = VoronoiPacking{.count = cells};
  return recipe;
}

}  // namespace

TEST_CASE("the gauge of platens tells the force on each of them, over the square of their first distance") {
  const Model model = model_of(solid(60e9, 0.2, 2650));
  Team team(1);
  Recipe recipe = two_spheres();
  recipe.supports.press = Platens{.axis = 2, .pace = 0.5, .material = 1};
  const Sample sample = make(model, recipe, team);
  Programme test;
  test.kind = TestKind::platens, test.axis = 2, test.final_strain = 0.1;
  test = fitted(test, sample);
  CHECK(test.strain_rate == Approx(0.5 / (2 * R)));
  CHECK(test.duration == Approx(0.1 * 2 * R / 0.5));
  State s = sample.state;
  const double low = 2e-6, high = 5e-6;  // how deep the plates press into both spheres
  s.boundary.walls[0].point.z() += low, s.boundary.walls[1].point.z() -= high;
  prepare(model, s, team);
  const double F0 = 2 * hertz(model.materials[0], low), F1 = 2 * hertz(model.materials[0], high);
  CHECK(wall_force(s, 0).z() == Approx(-F0).epsilon(1e-9));
  CHECK(wall_force(s, 1).z() == Approx(F1).epsilon(1e-9));
  CHECK(wall_force(s, 1).head<2>().norm() < 1e-12 * F1);
  const auto [back, front] = face_stresses(test, sample.state, s);
  CHECK(back == Approx(F0 / (4 * R * R)).epsilon(1e-9));
  CHECK(front == Approx(F1 / (4 * R * R)).epsilon(1e-9));
  CHECK(axial_stress(test, sample.state, s) == Approx(0.5 * (F0 + F1) / (4 * R * R)).epsilon(1e-9));
  CHECK(axial_strain(test, sample.state, s, Mat3::Zero()) == Approx((low + high) / (2 * R)).epsilon(1e-9));
  // A gauge of both plates as rollers have it: half of each, along the way of the upper one.
  const Gauge gauge{{{0, 0.5}, {1, -0.5}}, -Vec3::UnitZ(), 1, 3.0};
  CHECK(load_of(gauge, s) == Approx(0.5 * (F0 + F1)).epsilon(1e-9));
  CHECK(way_of(gauge, sample.state, s) == Approx(high).epsilon(1e-9));
  test.gauge = gauge;
  CHECK(test_stress(test, s, {}) == Approx(1.5 * (F0 + F1)).epsilon(1e-9));
}

TEST_CASE("a test that a stress ends looks for it in every step from a fifth of it on, along its own axis") {
  const Model model = model_of(solid(60e9, 0.2, 2650));
  Team team(1);
  Recipe recipe = two_spheres();
  recipe.supports.press = Platens{.axis = 1, .pace = 0.5, .material = 1};
  const Sample sample = make(model, recipe, team);
  Programme test;
  test.kind = TestKind::platens, test.axis = 1, test.final_strain = 0.1, test.final_stress = 3e6;
  test = fitted(test, sample);
  State s = sample.state;
  s.boundary.walls[1].point.y() -= 2e-6;
  prepare(model, s, team);
  const Landing landing = stress_landing(test, sample.state);
  CHECK(landing.axis == 1);
  CHECK(landing.near == Approx(0.6e6));
  CHECK(landing.left(s) == Approx(3e6 - axial_stress(test, sample.state, s)));
}

TEST_CASE("in a box of walls the axial stress is the force on two faces over their area") {
  const Model model = model_of(solid(60e9, 0.2, 2650));
  Team team(1);
  State s;
  const double depth = 3e-6, size = 2 * (R - depth);
  add(s, PolyEllipsoid::sphere(R), Vec3::Constant(R - depth), 2650);
  add_box(s, size);
  prepare(model, s, team);
  const double stress = hertz(model.materials[0], depth) / (size * size);
  for (int axis = 0; axis < 3; ++axis) {
    Programme test;
    test.axis = axis;
    CHECK(has_stress(test, s));
    CHECK(axial_stress(test, s, s) == Approx(stress).epsilon(1e-9));
    CHECK(axial_stress(test, s, s, measure(model, s)) == Approx(stress).epsilon(1e-9));
  }
}

TEST_CASE("the strain of a cell along its axis is what an affine map shortens it by; its stress is Love and Weber's") {
  const Model model = model_of(solid(60e9, 0.2, 2650));
  Team team(1);
  Recipe recipe;
  recipe.bounds = Bounds::periodic;
  recipe.grains = Lattice{.hexagonal = false, .radius = R, .layers = {4, 4, 4}};
  recipe.box = Vec3::Constant(8 * R);
  const Sample sample = make(model, recipe, team);
  State s = sample.state;
  Mat3 F = Vec3(1.01, 0.998, 0.97).asDiagonal();
  F(0, 2) = 0.02;
  s.boundary.cell.vectors = F * s.boundary.cell.vectors;
  Programme test;
  for (int axis = 0; axis < 3; ++axis) {
    test.axis = axis;
    CHECK(axial_strain(test, sample.state, s, sample.state.boundary.cell.vectors) ==
          Approx(1 - F(axis, axis)).epsilon(1e-12));
  }
  // All grains go with the map along z alone: contacts of depth 2 R e carry the force of two equal spheres.
  s = sample.state;
  const double e = 1e-3;
  s.boundary.cell.vectors(2, 2) *= 1 - e;
  for (auto& m : s.grains.motion) m.position.z() *= 1 - e;
  prepare(model, s, team);
  const Material& m = model.materials[0];
  const double E = m.youngs_modulus / (2 * (1 - m.poissons_ratio * m.poissons_ratio));
  const double force = 4.0 / 3 * E * std::sqrt(0.5 * R) * std::pow(2 * R * e, 1.5);
  test.axis = 2;
  CHECK(axial_stress(test, sample.state, s) == Approx(force / (4 * R * R)).epsilon(1e-6));
  test.axis = 0;
  CHECK(std::abs(axial_stress(test, sample.state, s)) < 1e-9 * force / (4 * R * R));
}

TEST_CASE("a network shows the elasticity that it was made for, no stiffer than if all cells moved with one strain") {
  for (const double poisson : {0.0, 0.03, 0.1425, 0.2, 0.26}) {
    const Network network = network_of({7e9, poisson});
    const Elasticity shown = solid_of(network);
    CHECK(shown.modulus == Approx(7e9).epsilon(1e-12));
    CHECK(shown.poissons_ratio == Approx(poisson).margin(1e-12));
    // Voigt's bound of springs of all directions, ratio r of shear to normal: E (2 + 3 r) / (4 + r), (1 - r) / (4 + r).
    const double r = network.ratio, bound = network.stiffness * (2 + 3 * r) / (4 + r);
    CHECK(shown.modulus < bound * (1 + 1e-9));
    CHECK(shown.modulus > 0.85 * bound);
    CHECK(std::abs(poisson - (1 - r) / (4 + r)) < 0.04);
  }
  const Network equal = network_of({1, 0});
  CHECK((equal.stiffness == 1 && equal.ratio == 1));
}

TEST_CASE("lattices are made as they are told: twelve or six contacts a grain, and their solid fraction") {
  const Model model = model_of(solid(60e9, 0.2, 2650));
  Team team(1);
  for (const bool hexagonal : {true, false}) {
    Recipe recipe;
    const Lattice lattice{.hexagonal = hexagonal, .radius = R * (1 + 1e-9), .layers = {4, 4, 4}};
    recipe.bounds = Bounds::periodic, recipe.grains = lattice, recipe.box = box_of(lattice, true) / (1 + 1e-7);
    CHECK(recipe.count() == 64);
    State s = make(model, recipe, team).state;
    CHECK(solid_volume(s.grains) / bulk_volume(s.boundary) ==
          Approx(hexagonal ? pi / std::sqrt(18.0) : pi / 6).epsilon(1e-6));
    for (auto& m : s.grains.motion) m.position /= 1 + 1e-7;
    prepare(model, s, team);
    CHECK(measure(model, s).contacts == 64 * (hexagonal ? 6 : 3));
  }
}

TEST_CASE("cells fill their box, and their bonds its volume three times: each is as long as it is stiff") {
  Model model = rock(elastic());
  model.materials[0].bond->damping = 0.1;
  const Vec3 box(4e-3, 5e-3, 6e-3);
  Team one(1), two(2);
  for (const Bounds bounds : {Bounds::periodic, Bounds::walls}) {
    const Recipe recipe = tessellation(bounds, box, 80);
    const Sample sample = make(model, recipe, one);
    CHECK(hash(sample.state) == hash(make(model, recipe, two).state));
    CHECK(solid_volume(sample.state.grains) == Approx(box.prod()).epsilon(1e-9));
    CHECK((sample.bonded() && sample.faces->bonds == sample.state.bonds.dashpot.size()));
    double volume = 0;  // two pyramids a face: of each cell a third of area times height
    for (const FaceBond& b : sample.state.bonds.face.row) volume += b.area * E0 / b.kn / 3;
    if (bounds == Bounds::periodic) CHECK(volume == Approx(box.prod()).epsilon(1e-6));
    if (bounds == Bounds::walls) CHECK((volume < 0.95 * box.prod() && volume > 0.5 * box.prod()));
    CHECK(sample.state.boundary.walls.size() == (bounds == Bounds::walls ? 6 : 0));
  }
}

TEST_CASE("clamps and rollers are where the cells end, and read what pulls and bends") {
  const Model model = rock(elastic());
  const Vec3 box(20e-3, 4e-3, 4e-3);
  Team team(1);
  Recipe recipe = tessellation(Bounds::open, box, 60);
  recipe.supports.clamps = {{.outward = -Vec3::UnitX(), .material = 1},
                            {.outward = Vec3::UnitX(), .velocity = Vec3(0.1, 0, 0), .material = 1}};
  recipe.supports.loads = {{.outward = Vec3::UnitZ(), .force = Vec3(0, 0, -3)}};
  const Sample pulled = make(model, recipe, team);
  REQUIRE(pulled.state.boundary.walls.size() == 2);
  CHECK(std::abs(pulled.state.boundary.walls[0].point.x()) < 1e-9);
  CHECK(pulled.state.boundary.walls[1].point.x() == Approx(box.x()).epsilon(1e-9));
  REQUIRE(pulled.gauge);
  CHECK(pulled.gauge->moving == 1);
  CHECK(1 / pulled.gauge->stress_per_load == Approx(box.y() * box.z()).epsilon(1e-9));
  Vec3 load = Vec3::Zero();
  for (const DeadLoad& l : pulled.state.bonds.load) load += l.force;
  CHECK((load - Vec3(0, 0, -3)).norm() < 1e-12);

  recipe.supports = {};
  recipe.supports.press =
      Rollers{.axis = 2, .span = 0, .outer = 16e-3, .inner = 6e-3, .radius = 2e-3, .speed = 0.1, .material = 1};
  const Sample bent = make(model, recipe, team);
  REQUIRE(bent.state.boundary.walls.size() == 4);
  for (std::size_t w = 0; w < 4; ++w) {
    const Wall& wall = bent.state.boundary.walls[w];
    CHECK(wall.point.z() == Approx(w < 2 ? -2e-3 : 6e-3).epsilon(1e-6));  // on plane faces
    CHECK(std::abs(wall.point.x() - 10e-3) == Approx(w < 2 ? 8e-3 : 3e-3).epsilon(1e-9));
    CHECK(wall.velocity.z() == (w < 2 ? 0 : -0.1));
    // A prism of 32 corners about the roller's axis, a fifth longer than the beam is wide.
    const auto& roller = std::get<RollerWall>(wall.shape);
    const HullView hull = (*bent.state.grains.hulls)[roller.hull];
    CHECK(hull.vertices == 64);
    Vec3 middle = Vec3::Zero();
    for (int k = 0; k < hull.vertices; ++k) {
      const Vec3& corner = hull.vertex[k];
      CHECK(corner.cross(roller.axis).norm() == Approx(2e-3).epsilon(1e-6));
      CHECK(std::abs(corner.dot(roller.axis)) == Approx(0.6 * 4e-3).epsilon(1e-6));
      middle += corner / 64;
    }
    CHECK(middle.norm() < 1e-9 * 2e-3);
  }
  // The upper two move: the way of the test is theirs.
  State lower = bent.state;
  for (Wall& wall : lower.boundary.walls) wall.point += 1e-3 * wall.velocity;
  CHECK(way_of(*bent.gauge, bent.state, lower) == Approx(1e-4).epsilon(1e-12));
  CHECK(load_of({bent.gauge->walls, Vec3::Zero()}, lower) == 0);
  std::array<double, 4> weight{};
  for (const auto& [w, part] : bent.gauge->walls) weight.at(w) += part;
  CHECK(weight == std::array<double, 4>{0.5, 0.5, -0.5, -0.5});
  CHECK(bent.gauge->stress_per_load == Approx(3 * (16e-3 - 6e-3) / (2 * 4e-3 * 4e-3 * 4e-3)).epsilon(1e-9));
}

TEST_CASE("a sample that was prepared bears its pressure, and a piece of a packing is a smaller one of its kind") {
  Model model = model_of(solid(60e9, 0.2, 2650, 0.3));
  Team team(2);
  Recipe recipe;
  recipe.bounds = Bounds::periodic, recipe.box = Vec3::Constant(8e-3);
  recipe.grains = RandomPacking{.radius = {.mean = 0.5e-3}, .solid_fraction = 0.6};
  recipe.preparation = Preparation{.pressure = 1e6, .friction = 0.1};
  CHECK(solid_volume(make(model, recipe, team).state.grains) == Approx(0.6 * recipe.box.prod()).epsilon(1e-9));
  const State s = make_ready(model, recipe, team);
  const Vec3 stress = -measure(model, s).stress.diagonal();
  for (int k = 0; k < 3; ++k) CHECK(std::abs(stress[k] / 1e6 - 1) <= compress_tolerance);
  CHECK((s.time == 0 && s.steps == 0 && s.dt > 0));
  CHECK(unbearable(model, recipe, 1e6).empty());
  CHECK_THAT(unbearable(model, recipe, 60e9), Catch::Contains("too high for this contact stiffness"));
  Recipe eggs;  // flatter than a sphere by cbrt(2): that squared is what it bears more
  Listed listed(2);
  listed[0].spec.shape = PolyEllipsoid{Vec3(2, 1, 1) * 1e-3, Vec3(2, 1, 1) * 1e-3};
  listed[1].spec.shape = PolyEllipsoid::sphere(2e-3);
  eggs.grains = listed;
  const double bears = std::pow(2, 2.0 / 3) * unbearable_pressure(model, std::cbrt(2) * 1e-3);
  CHECK(unbearable(model, eggs, 0.999 * bears).empty());
  CHECK_FALSE(unbearable(model, eggs, 1.001 * bears).empty());
  CHECK_FALSE(piece_of(recipe));
  recipe.box *= 4;
  const auto piece = piece_of(recipe);
  REQUIRE(piece);
  CHECK(piece->count() == Approx(1000).epsilon(1e-9));
  CHECK(boundary_of(*piece).cell.volume() == Approx(piece->box.prod()).epsilon(1e-12));
}

TEST_CASE("what cannot be made is refused with the place of whoever asked for it") {
  const Model model = model_of(solid(60e9, 0.2, 2650));
  Team team(1);
  Recipe recipe = two_spheres();
  const auto said = [&] {
    try {
      make(model, recipe, team);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  CHECK(said().empty());
  OwnWall wall{.place = "here", .place_of_normal = "there"};
  wall.wall.point = Vec3(0, 0, 2 * R), wall.wall.shape = PlaneWall{Vec3::UnitZ()}, wall.wall.material = 1;
  recipe.walls = {wall};
  CHECK(said() == "there: grain 0 is behind this wall: its normal points to where grains may be");
  recipe.walls[0].wall.point.z() = -2 * R;
  CHECK(said().empty());
  recipe.walls.push_back(recipe.walls[0]);
  CHECK_THAT(said(), Catch::StartsWith("here: this wall is where wall 0 is"));
  recipe.walls[1].wall.shape = PlaneWall{-Vec3::UnitZ()}, recipe.walls[1].wall.point.z() = -3 * R;
  CHECK_THAT(said(), Catch::StartsWith("there: no place is on the inner side"));
  recipe.walls.clear();
  std::get<Listed>(recipe.grains)[0].spec.material = 2;
  CHECK(said() == "material 2: the model has 2");
  recipe.grains = Listed(1);
  std::get<Listed>(recipe.grains)[0].vertices = std::vector<Vec3>{Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};
  std::get<Listed>(recipe.grains)[0].place = "hull";
  CHECK_THAT(said(), Catch::StartsWith("hull: "));
  recipe.grains = Listed();
  CHECK(said() == "the sample has no grains");
  recipe = tessellation(Bounds::periodic, Vec3::Zero(), 10);
  CHECK_THAT(said(), Catch::Contains("box"));
  recipe = tessellation(Bounds::open, Vec3::Constant(R), 10);
  recipe.supports.clamps = {{.outward = Vec3::UnitX()}};
  CHECK_THAT(said(), Catch::Contains("no bond"));
}

TEST_CASE("a preparation presses until stresses are within a fiftieth at five times the unbalance, then it holds") {
  Model model = model_of(solid(60e9, 0.2, 2650, 0.1));
  set_damping(model, 0.3);
  Team team(2);
  Recipe recipe;
  recipe.bounds = Bounds::periodic, recipe.box = Vec3::Constant(8e-3);
  recipe.grains = RandomPacking{.radius = {.mean = 0.5e-3}, .solid_fraction = 0.6};
  State s = make(model, recipe, team).state;
  prepare(model, s, team);
  const QuasiStatic o;
  constexpr double pressure = 1e6;
  std::vector<double> off;
  std::size_t ready = 0;  // rounds that might have ended it
  bool holds = false;
  compress_isotropically(model, o, s, pressure, team, [&](double done) {
    holds = holds || done >= 0.96;
    if (holds) return true;
    const Measurement m = measure(model, s);
    off.push_back((m.stress.diagonal() / pressure + Vec3::Ones()).cwiseAbs().maxCoeff());
    ready += off.back() < 0.02 && m.unbalanced_force < 5 * o.unbalanced_force;
    return true;
  });
  REQUIRE((holds && off.size() > 10));
  CHECK(ready == 1);
  CHECK(off.back() < 0.02);
  CHECK(off.back() > 0.01);  // half of it would have taken longer
}

TEST_CASE("a frame shows a box of walls where its walls are") {
  State s;
  const Vec3 low(1, 2, -3), high(1.5, 4, 5);
  for (int k = 0; k < 6; ++k) {
    Wall wall;
    wall.name = "a wall", wall.point = k % 2 == 0 ? low : high;
    wall.shape = PlaneWall{(k % 2 == 0 ? 1.0 : -1.0) * Vec3::Unit(k / 2)};
    s.boundary.walls.push_back(wall);
  }
  std::string corners;  // as they stand in the file: few numbers are not packed
  for (int corner = 0; corner < 8; ++corner)
    for (int k = 0; k < 3; ++k) {
      const auto x = static_cast<float>((corner >> k & 1) != 0 ? high[k] : low[k]);
      corners.append(reinterpret_cast<const char*>(&x), sizeof(x));
    }
  const grus::app::test::Scratch scratch;
  write_grains(scratch.path + "/grains.hdf", s);
  std::ifstream in(scratch.path + "/grains.hdf", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  CHECK(bytes.find(corners) != std::string::npos);
}
