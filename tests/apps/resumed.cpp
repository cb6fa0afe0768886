// SPDX-License-Identifier: LGPL-3.0-or-later
// Runs that are saved and loaded after every step end in the bytes of runs that are not: crushing halves and balls,
// softening faces, cleaving cells, swelling grains, lists that are mended, servos.
#include <fmt/format.h>

#include <fstream>

#include "apps/scene/prepare_sample.hpp"
#include "dem/io/archive.hpp"
#include "dem/rve/check_state.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/step.hpp"
#include "dem/sample/make.hpp"
#include "tests/apps/scratch.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using grus::app::RveScene;
using grus::app::test::Scratch;

namespace {

/// A test of a scene, at its beginning.
struct Begun {
  RveScene scene;
  State state;
  const Model& model() const { return scene.model; }
};

Begun begun(const std::string& text, Team& team) {
  const Scratch scratch;
  const std::string file = scratch.path + "/scene.toml";
  std::ofstream(file) << text;
  RveScene scene = grus::app::read_rve_scene(file, {});
  const Sample sample = make(scene.model, scene.recipe, team);
  grus::app::settle(scene, sample);
  State state = start_from(compressed(sample.state, scene.model, scene.recipe.preparation, team), scene.model,
                           scene.recipe.preparation, team);
  begin_loading(scene.model, state, scene.test.loading);
  return {std::move(scene), std::move(state)};
}

/// The state as a resumed run has it.
State resumed(const Model& model, const State& state) {
  State again = state_of(bytes_of(state));
  check_state(model, again);
  return again;
}

void check_plan(const State& s, const State& again) {
  const Plan &p = s.contacts.plan, &q = again.contacts.plan;
  CHECK((p.a == q.a && p.b == q.b && p.law == q.law && p.target == q.target && p.shift == q.shift &&
         p.images == q.images));
  CHECK((p.remote == q.remote && p.remote_row == q.remote_row && p.before == q.before && p.tile_work == q.tile_work));
  CHECK(p.load.size() == q.load.size());
  CHECK((s.contacts.index.first == again.contacts.index.first && s.contacts.index.entry == again.contacts.index.entry));
}

/// What happens in `steps` steps of a test, one by one, resumed after each of them and not resumed.
State both(const std::string& text, std::uint64_t steps, int threads = 1) {
  Team team(threads);
  const Begun test = begun(text, team);
  State whole = test.state, saved = test.state;
  for (std::uint64_t k = 0; k < steps; ++k) {
    for (State* s : {&whole, &saved}) update_time_step(test.model(), *s, team), run_steps(test.model(), *s, 1, team);
    State again = resumed(test.model(), saved);
    if (k % 50 == 0) check_plan(saved, again);
    saved = std::move(again);
    if (bytes_of(saved) != bytes_of(whole)) {
      CHECK(k == steps);  // the first step after which they differ
      break;
    }
  }
  CHECK(bytes_of(saved) == bytes_of(whole));
  return whole;
}

const std::string sand = R"(
[material.sand]
density = 2650
youngs_modulus = "6 GPa"
poissons_ratio = 0.17
friction = 0.5
restitution = 0.5
damping = 0.2
)";
const std::string splitting = R"(
[material.sand.fracture]
model = "polyellipsoid-split"
hoek_brown = { compressive_strength = "20 MPa", m = 20.56 }
weibull = { modulus = 3.1, reference_radius = "0.3 mm", size_exponent = 0.9677 }
cohesive_springs = { per_plane = 4, toughness = "1.77 MPa m^0.5", max_opening = 0.05, stiffness_ratio = 0.1 }
turn_to_plane = true
rounding = 0.1
shape_transition = { ratio = 0.25, time = "1 us" }
)";
const std::string numerics =
    "[numerics]\nfracture_every = 5\nestimate_every = 5\nmax_energy_error = 1e9\nmax_overlap = 0.9\n";

}  // namespace

TEST_CASE("halves with springs and fines and changing shapes between walls") {
  const State s = both("seed = 3\n" + sand + splitting + R"([packing]
kind = "random"
box = ["2 mm", "2 mm", "2 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.4 mm" }
solid_fraction = 0.5
[boundary]
kind = "walls"
[loading]
kind = "uniaxial-strain"
strain_rate = "4000 1/s"
final_strain = 0.3
[output]
split_statistics = true
)" + numerics,
                       700);
  CHECK(s.ledger.breakages > 5);
  CHECK(s.ledger.fines.mass > 0);
  CHECK(s.ledger.splits.events > 0);
}

TEST_CASE("balls that swell in a cell that a servo drives") {
  Team team(1);
  const Begun test = begun(sand + R"([material.sand.fracture]
model = "apollonian-14"
contact_strength = { strength = "60 MPa", area = "hertz" }
scatter = { distribution = "log-normal", variation = 0.3, reference_diameter = "0.5 mm" }
lost_mass = "swell"
smallest_radius = "0.15 mm"
[packing]
kind = "random"
box = ["1.6 mm", "1.6 mm", "1.6 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.3 mm" }
solid_fraction = 0.55
[boundary]
kind = "periodic"
[loading]
kind = "triaxial"
strain_rate = "4000 1/s"
confining_pressure = "5 MPa"
final_strain = 0.2
[output]
history_interval = 0.01
)" + numerics,
                           team);
  State whole = test.state, saved = test.state;
  const double end = 2e-5;
  REQUIRE(load(test.model(), whole, test.scene.test.loading, end, team));
  int stops = 0;
  while (!load(test.model(), saved, test.scene.test.loading, end, team, [](double) { return false; }))
    saved = resumed(test.model(), saved), ++stops;
  CHECK(stops > 100);
  CHECK(bytes_of(saved) == bytes_of(whole));
  CHECK(whole.ledger.breakages > 0);
  CHECK(whole.servo.at > 0);
}

const std::string rock = R"(
[material.rock]
density = "2500 kg/m^3"
contact = "overlap"
friction = 0.5
damping = 0.1
[material.rock.bond]
modulus = "20 GPa"
poissons_ratio = 0.2
criterion = "cohesive"
tension = "6 MPa"
cohesion = "18 MPa"
friction_angle = "30 deg"
fracture_energy = "15 J/m^2"
weibull = 6
)";
const std::string disc = R"([packing]
kind = "voronoi"
cylinder = { diameter = "10 mm", length = "2 mm" }
cells = 30
extruded = true
[loading]
kind = "platens"
axis = "y"
strain_rate = "400 1/s"
final_strain = 0.03
)";

TEST_CASE("faces that soften and break and are handed to contacts") {
  const State s = both(rock + disc + numerics + "[output]\nbursts = \"1 us\"\n", 1500);
  CHECK(s.ledger.bonds_broken > 5);
  CHECK(s.bonds.broken.size() == s.ledger.bonds_broken);
}

TEST_CASE("cells that cleave, with inertia by step") {
  const State s = both(rock + R"([material.rock.fracture]
model = "cleavage"
toughness = "0.1 MPa m^0.5"
flaw = "0.1 mm"
planes = [[1, 0, 0], [0, 1, 0]]
offsets = [0, 0.3]
crystal = { axis = [0, 0, 1], angles = ["0 deg", "30 deg"] }
max_generations = 2
)" + disc + numerics + "inertia = { step = \"400 ns\" }\n",
                       1500);
  CHECK(s.ledger.breakages > 3);
  CHECK(s.grains.turn_mass.size() == s.grains.size());
  CHECK(s.ledger.inertia != 0);
}

TEST_CASE("clamped and loaded cells") {
  const State s = both(rock + R"([packing]
kind = "voronoi"
box = ["12 mm", "3 mm", "4 mm"]
cells = 40
[[clamp]]
where = "x=min"
[[clamp]]
where = "x=max"
velocity = [0.1, 0.02, 0]
[[load]]
where = "z=max"
force = [0, 0, "-3 N"]
ramp = "10 us"
[loading]
kind = "free"
duration = "500 us"
)" + numerics,
                       300);
  CHECK(s.ledger.work > 0);
}

TEST_CASE("strays among grains that creep: the list is mended") {
  std::string grains;
  for (int i = 0; i < 64; ++i)
    grains += fmt::format("[[grain]]\nradius = 3e-4\nposition = [{}, {}, {}]\n", 6e-4 * (i & 3), 6e-4 * (i >> 2 & 3),
                          6e-4 * (i >> 4));
  grains += "[[grain]]\nradius = 1e-4\nposition = [3e-4, 3e-4, 2.6e-3]\nvelocity = [4, 1, -40]\n";
  const State s = both(sand + grains + R"([boundary]
kind = "open"
[loading]
kind = "free"
duration = "1 ms"
)" + numerics,
                       400, 2);
  CHECK(s.reference.mends > 0);
}
