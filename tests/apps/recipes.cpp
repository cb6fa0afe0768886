// SPDX-License-Identifier: LGPL-3.0-or-later
// A recipe makes the bytes of the scene that asks for the same.
#include <fstream>

#include "apps/scene/prepare_sample.hpp"
#include "dem/io/archive.hpp"
#include "dem/io/checkpoint.hpp"
#include "dem/packing/clusters.hpp"
#include "dem/packing/voronoi.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/sample/network.hpp"
#include "tests/apps/scratch.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using grus::app::RveScene;
using grus::app::test::Scratch;

namespace {

const std::string sand = R"(
[material.sand]
density = 2650
youngs_modulus = "60 GPa"
poissons_ratio = 0.2
friction = 0.3
)";
const std::string rock = R"(
[material.rock]
density = 2000
contact = "overlap"
friction = 0.4
[material.rock.bond]
modulus = "5 GPa"
tension = "10 MPa"
cohesion = "20 MPa"
fracture_energy = "50 J/m^2"
)";

Model sand_model() {
  Model model;
  model.materials = {grus::dem::test::solid(60e9, 0.2, 2650, 0.3)};
  model.materials[0].name = "sand";
  model.numerics.safety = 0.7;  // of a unit cell
  return model;
}

Model rock_model() {
  Model model;
  const Network network = network_of({5e9, 0.2});
  Material m = grus::dem::test::solid(60e9, 0.25, 2000, 0.4);
  m.name = "rock";
  m.contact = Foundation::Of{.modulus = network.stiffness, .shear_ratio = network.ratio};
  m.bond = BondModel{.stiffness = network.stiffness,
                     .ratio = network.ratio,
                     .tension = 10e6,
                     .cohesion = 20e6,
                     .friction = 0.4,
                     .energy_1 = 50,
                     .energy_2 = 50};
  model.materials = {m};
  model.law = Foundation{};
  model.numerics.safety = 0.7;
  return model;
}

/// Bytes of the state in which a scene's test begins, and of the state that a recipe makes ready.
void same_bytes(const std::string& text, Model model, const Recipe& recipe) {
  const Scratch scratch;
  const std::string file = scratch.path + "/scene.toml";
  const bool bounded = text.find("[boundary]") != std::string::npos;
  std::ofstream(file) << text << (bounded ? "" : "[boundary]\nkind = \"periodic\"\n");
  const RveScene scene = grus::app::read_unit_cell(file, {});
  Team one(1), two(2);
  make_pair_laws(model);
  model.motion.turn_spheres = recipe.listed() != nullptr;  // as scenes have it
  const State asked = grus::app::prepare_sample(scene, one);
  const State made = make_ready(model, recipe, one);
  CHECK((bytes_of(asked) == bytes_of(made)));
  CHECK(hash(asked) == hash(make_ready(model, recipe, two)));
  model.seed += 1;
  if (recipe.listed() == nullptr) CHECK(hash(asked) != hash(make_ready(model, recipe, one)));
}

}  // namespace

TEST_CASE("a random packing from a recipe is that of the scene, byte by byte") {
  Recipe recipe;
  recipe.bounds = Bounds::periodic, recipe.box = Vec3::Constant(3e-3);
  RandomPacking packing;
  packing.radius = {.kind = "uniform", .mean = 0.5 * (0.2e-3 + 0.3e-3), .min = 0.2e-3, .max = 0.3e-3};
  packing.solid_fraction = 0.6;
  recipe.grains = packing;
  recipe.preparation = Preparation{.pressure = 1e6, .friction = 0.1};
  Model model = sand_model();
  model.seed = 7;
  same_bytes(sand + R"(
[packing]
kind = "random"
box = ["3 mm", "3 mm", "3 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.3 mm" }
solid_fraction = 0.6
seed = 7
[preparation]
pressure = "1 MPa"
friction = 0.1
)",
             model, recipe);
}

TEST_CASE("a lattice and grains one by one from a recipe are those of the scene, byte by byte") {
  Recipe recipe;
  recipe.bounds = Bounds::periodic;
  const Lattice lattice{.radius = 0.5e-3, .layers = {3, 4, 2}};
  recipe.grains = lattice, recipe.box = box_of(lattice, true);
  same_bytes(sand + R"(
[packing]
kind = "hcp"
radius = { distribution = "constant", mean = "0.5 mm" }
layers = [3, 4, 2]
)",
             sand_model(), recipe);
  Listed grains(2);
  grains[0].spec.shape = PolyEllipsoid::sphere(0.5e-3), grains[0].spec.position = Vec3(1e-3, 1e-3, 1e-3);
  grains[0].spec.velocity = Vec3(0.1, 0, 0);
  grains[1].spec.shape.plus = Vec3(1e-3, 0.5e-3, 0.7e-3), grains[1].spec.shape.minus = Vec3(0.9e-3, 0.6e-3, 0.7e-3);
  grains[1].spec.position = Vec3(3e-3, 3e-3, 3e-3), grains[1].spec.spin = Vec3(0, 0, 5);
  grains[1].spec.orientation = Quat(0.8, 0.6, 0, 0);
  Recipe pair;
  pair.bounds = Bounds::periodic, pair.box = Vec3::Constant(6e-3), pair.grains = grains;
  same_bytes(sand + R"(
[[grain]]
radius = "0.5 mm"
position = ["1 mm", "1 mm", "1 mm"]
velocity = [0.1, 0, 0]
[[grain]]
shape = "polyellipsoid"
semi_axes = [1e-3, 0.9e-3, 0.5e-3, 0.6e-3, 0.7e-3, 0.7e-3]
position = ["3 mm", "3 mm", "3 mm"]
orientation = [0.8, 0.6, 0, 0]
spin = [0, 0, 5]
[boundary]
kind = "periodic"
box = ["6 mm", "6 mm", "6 mm"]
)",
             sand_model(), pair);
}

TEST_CASE("hulls and Voronoi cells from a recipe are those of the scene, byte by byte") {
  Recipe recipe;
  recipe.bounds = Bounds::periodic, recipe.box = Vec3::Constant(4e-3);
  recipe.grains = RandomPacking{
      .radius = {.mean = 0.4e-3}, .solid_fraction = 0.18, .hulls = RandomHulls{.rounds = 3, .aspect = Vec3(1, 1, 0.7)}};
  Model model = rock_model();
  model.materials[0].bond.reset();
  model.materials[0].contact = Foundation::Of{.modulus = 8e9, .shear_ratio = 2.0 / 7};
  same_bytes(R"(
[material.rock]
density = 2000
contact = "overlap"
friction = 0.4
youngs_modulus = "8 GPa"
[packing]
kind = "random"
box = ["4 mm", "4 mm", "4 mm"]
radius = { distribution = "constant", mean = "0.4 mm" }
solid_fraction = 0.18
hulls = { relax = 3, aspect = [1, 1, 0.7] }
)",
             model, recipe);
  recipe.grains = VoronoiPacking{.count = 70, .rounds = 4, .clusters = 5};
  Model bonded = rock_model();
  bonded.materials[0].bond->between = 5e6;
  same_bytes(rock + R"(between = "5 MPa"
[packing]
kind = "voronoi"
box = ["4 mm", "4 mm", "4 mm"]
cells = 70
relax = 4
grains = "clusters"
clusters = 5
)",
             bonded, recipe);

  // Which bonds are the weaker ones, by the clusters of the same seed.
  Team team(1);
  const TessellationSpace space = recipe.periodic() ? periodic_space(recipe.box) : box_space(recipe.box);
  auto cells = voronoi_packing(space, 70, 4, bonded.seed, team);
  deal_to_clusters(space, 5, bonded.seed, team, cells);
  const Sample sample = make(bonded, recipe, team);
  std::size_t weak = 0;
  for (const FaceBond& b : sample.state.bonds.face.row) {
    const bool apart = cells.cluster[b.ends.a] != cells.cluster[b.ends.b];
    CHECK(b.tension == (apart ? 5e6 : 10e6));
    weak += apart;
  }
  CHECK(weak > 20);
}

TEST_CASE("larger grains that stand for smaller ones scatter about the strength of those, by either law") {
  const Scratch scratch;
  const std::string file = scratch.path + "/scene.toml";
  std::ofstream(file) << R"([material.m]
youngs_modulus = 1e9
density = 2000.0
[material.m.fracture]
model = "polyellipsoid-split"
contact_strength = { strength = 1e8, area = "hertz" }
scatter = { variation = 0.3, reference_diameter = 2e-3, size_exponent = 0.4 }
[packing]
kind = "random"
box = [0.04, 0.04, 0.04]
radius = { distribution = "constant", mean = 1e-3 }
solid_fraction = 0.3
[boundary]
kind = "walls"
[loading]
kind = "oedometric-stress"
strain_rate = 10
final_stress = 1e6
scale = 4
)";
  const auto scatter = [&](const std::vector<std::string>& changes) {
    return std::get<grus::dem::Scatter>(
               grus::app::read_rve_scene(file, changes).model.materials[0].fracture->strength_law)
        .reference_diameter;
  };
  CHECK(scatter({}) == Approx(8e-3).epsilon(1e-14));
  CHECK(scatter({"loading.scale=1"}) == Approx(2e-3).epsilon(1e-14));
}
