// SPDX-License-Identifier: LGPL-3.0-or-later
// The summary of a test of grains, key by key, against the state in which the test ended.
#include <fmt/format.h>

#include <fstream>

#include "apps/rve/rve_run.hpp"
#include "apps/scene/prepare_sample.hpp"
#include "dem/io/archive.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/sample/gauge.hpp"
#include "tests/apps/scratch.hpp"
#include "tests/helpers.hpp"

using namespace grus;
using namespace grus::app;
using grus::app::test::Scratch;

namespace {

const std::string sand = R"(
title = "Weak"
seed = 7
material.a = { density = 2500, youngs_modulus = "1 GPa", friction = 0.4, restitution = 0.4, damping = 0.1 }
boundary.kind = "periodic"
output = { frames = 3, last_state = true }
[packing]
kind = "random"
box = ["5 mm", "5 mm", "5 mm"]
radius = { distribution = "constant", mean = "0.5 mm" }
solid_fraction = 0.55
[loading]
kind = "uniaxial-strain"
strain_rate = 20
final_strain = 0.12
)";

const std::string fracture =
    "material.a.fracture={model=\"apollonian-14\", max_generations=1, contact_strength={strength=\"5 MPa\", "
    "area=\"angle\", angle=\"20 "
    "deg\"}}";

struct Ran {
  nlohmann::json summary;
  std::string history;
  dem::State first, last;
  int status;
};

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Runs a scene as grus-rve does; `parts`: it is stopped as soon as can be, and gone on with, so many times.
Ran run(const std::string& text, const std::vector<std::string>& sets, int parts = 0) {
  const Scratch scratch;
  Options options;
  options.scene = scratch.path + "/scene.toml", options.directory = scratch.path + "/out", options.overrides = sets;
  options.quiet = true, options.threads = 1;
  std::ofstream(options.scene) << text;
  std::filesystem::create_directory(options.directory);
  dem::Team team(1);
  Ran ran;
  for (int part = 0; part <= parts; ++part) {
    const Clock clock;
    RveScene scene = read_rve_scene(options.scene, sets);
    dem::Sample sample = dem::make(scene.model, scene.recipe, team);
    settle(scene, sample);
    dem::Checkpoint kept;
    Begun begun;
    options.resume = part > 0, options.started = Clock(), options.max_time = part < parts ? 1e-9 : 0;
    if (options.resume) {
      kept = dem::read_checkpoint(options.directory + "/checkpoint.h5");
    } else {
      Base base = prepare_base(scene, &sample, team, {});
      begun.state = dem::start_from(std::move(base.state), scene.model, scene.recipe.preparation, team, {});
      begun.prepared = tell_preparation(scene, base.packed_void_ratio, begun.state, {}, base.density);
      dem::begin_loading(scene.model, begun.state, scene.test.loading);
      ran.first = begun.state;
    }
    ran.status = RveRun(options, scene, sample, team, std::move(begun), kept, clock, clock.wall()).go();
    if (part < parts) REQUIRE(ran.status == out_of_time);
  }
  ran.last = dem::state_of(dem::read_checkpoint(options.directory + "/checkpoint.h5").parts.at(0));
  ran.summary = nlohmann::json::parse(text_of(options.directory + "/summary.json"));
  ran.history = text_of(options.directory + "/history.csv");
  return ran;
}

}  // namespace

TEST_CASE("a test of grains that break is told by its last state and its rows, in one piece and in five") {
  const Ran whole = run(sand, {fracture}), parted = run(sand, {fracture}, 4);
  CHECK((whole.status == finished && parted.status == finished));
  CHECK(whole.history == parted.history);
  nlohmann::json a = whole.summary, b = parted.summary;
  for (nlohmann::json* s : {&a, &b}) s->erase("seconds");
  CHECK(a == b);

  const dem::State &first = whole.first, &last = whole.last;
  const dem::Ledger& l = last.ledger;
  REQUIRE(l.breakages > 3);
  const auto& s = whole.summary;
  CHECK((s["title"] == "Weak" && s["status"] == 0 && s["ending"] == "finished" && s["seed"] == 7 && s["threads"] == 1));
  const auto& counts = s["counts"];
  CHECK((counts["grains_start"] == first.grains.size() && counts["grains"] == last.grains.size()));
  CHECK((counts["breakages"] == l.breakages && counts["bonds_broken"] == 0 && counts["steps"] == last.steps));
  CHECK((counts["grain_steps"] == last.grain_steps && counts["history_rows"] == 201 && !counts.contains("fragments")));
  CHECK(std::count(whole.history.begin(), whole.history.end(), '\n') == 202);
  const double solid = dem::solid_volume(first.grains), bulk = 125e-9;
  CHECK(s["sample"]["bulk_density_kg_m3"].get<double>() == Approx(2500 * solid / bulk));
  CHECK(s["sample"]["solid_fraction"].get<double>() == Approx(solid / bulk));
  CHECK(s["sample"]["void_ratio"].get<double>() == Approx(bulk / solid - 1));
  CHECK(s["mass"]["start_kg"].get<double>() == Approx(2500 * solid));
  CHECK(s["mass"]["lost_kg"] == l.fines.mass);
  CHECK(s["mass"]["grains_kg"].get<double>() + l.fines.mass == Approx(2500 * solid).epsilon(1e-12));
  CHECK((s["fines"]["mass_kg"] == l.fines.mass && s["fines"]["kinetic_J"] == l.fines.kinetic));
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    CHECK(s["fines"]["momentum_kg_m_s"][i] == l.fines.momentum[k]);
    CHECK(s["fines"]["angular_momentum_kg_m2_s"][i] == l.fines.angular_momentum[k]);
  }
  const std::map<std::string, double> energies{{"work_J", l.work},
                                               {"start_J", l.start},
                                               {"friction_J", l.friction},
                                               {"damping_J", l.damping},
                                               {"fracture_J", l.fracture},
                                               {"local_damping_J", l.local_damping},
                                               {"handed_J", l.handed},
                                               {"split_elastic_J", l.split},
                                               {"fines_kinetic_J", l.fines.kinetic},
                                               {"reshape_J", l.reshape},
                                               {"split_added_J", l.split_added},
                                               {"bond_friction_J", l.bond_friction},
                                               {"energy_unexplained_J", l.unexplained},
                                               {"fracture_area_m2", l.fracture_area},
                                               {"split_force_residual_N", l.residual_force}};
  for (const auto& [name, value] : energies) {
    INFO(name);
    CHECK(s["energy"][name] == value);
  }
  CHECK(s["energy"]["kinetic_J"].get<double>() == Approx(dem::kinetic_energy(last.grains)));
  CHECK((!s.contains("preparation") && !s.contains("cells") && !s.contains("stages") && !s.contains("inertia")));
  const auto& results = s["results"];
  CHECK(results["final_time_s"].get<double>() == Approx(0.12 / 20));
  CHECK(results["final_void_ratio"].get<double>() ==
        Approx(bulk * 0.88 / dem::solid_volume(last.grains) - 1).epsilon(1e-6));
  CHECK((s["seconds"]["cpu"] >= 0 && s["seconds"]["loading_wall"] > 0 && s["seconds"]["preparation_wall"] > 0));

  // The first grain breaks between two rows, the largest stress may lie between two: no further off than rows are
  // apart.
  std::istringstream rows(whole.history);
  std::string line, word;
  std::getline(rows, line);
  std::vector<std::string> names;
  for (std::istringstream head(line); std::getline(head, word, ',');) names.push_back(word);
  const auto column = [&](const std::string& name) {
    const auto at = std::find(names.begin(), names.end(), name);
    REQUIRE(at != names.end());
    return static_cast<std::size_t>(at - names.begin());
  };
  const std::size_t stress = column("stress_zz_Pa"), broken = column("breakages");
  double peak = 0, intact = 0, now = 0, apart = 0;
  while (std::getline(rows, line)) {
    std::vector<double> row;
    for (std::istringstream values(line); std::getline(values, word, ',');) row.push_back(std::stod(word));
    apart = std::max(apart, std::abs(now + row.at(stress)));
    now = -row.at(stress);
    peak = std::max(peak, now);
    if (row.at(broken) == 0) intact = peak;
  }
  const double largest = results["peak_axial_stress_Pa"], strength = results["peak_before_breakage_Pa"];
  CHECK(largest >= peak * (1 - 1e-6));
  CHECK(largest < peak + apart);
  CHECK((strength >= intact * (1 - 1e-6) && strength < intact + apart));
  CHECK(results["final_axial_stress_Pa"].get<double>() == Approx(now).epsilon(1e-6));
  CHECK(results["peak_axial_stress_is_last"] == (std::abs(largest - now) < 1e-6 * peak));
}

TEST_CASE("a summary tells of a preparation where there was one, of stages where there are some") {
  const Ran plain = run(sand, {"loading.final_strain=0.01"});
  CHECK((!plain.summary.contains("preparation") && !plain.summary.contains("stages")));
  CHECK((!plain.summary.contains("fines") && !plain.summary["results"].contains("peak_before_breakage_Pa")));
  const Ran pressed = run(sand, {"preparation.pressure=\"50 kPa\"", "loading.final_strain=0.01"});
  const auto& told = pressed.summary["preparation"];
  CHECK(told["asked_stress_Pa"] == nlohmann::json{5e4, 5e4, 5e4});
  CHECK(told["worst_stress_error"] <= dem::compress_tolerance);
  for (std::size_t k = 0; k < 3; ++k)
    CHECK(told["stress_Pa"][k].get<double>() == Approx(5e4).epsilon(dem::compress_tolerance));
  CHECK(told["packed_void_ratio"].get<double>() == Approx(1 / 0.55 - 1).epsilon(1e-6));
  CHECK(told["void_ratio"] < told["packed_void_ratio"]);
  CHECK(told["void_ratio"].get<double>() == Approx(pressed.summary["sample"]["void_ratio"].get<double>()));
  const Ran parted = run(sand, {"preparation.pressure=\"50 kPa\"", "loading.final_strain=0.01"}, 2);
  CHECK(parted.summary["preparation"] == told);
  const Ran staged = run(sand.substr(0, sand.find("[loading]")) +
                             "[[stage]]\nkind = \"compress\"\nstrain_rate = 20\nrows = 3\nuntil = { strain = 0.01 }\n",
                         {});
  REQUIRE(staged.summary["stages"].size() == 1);
}
