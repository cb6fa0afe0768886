// SPDX-License-Identifier: LGPL-3.0-or-later
// What the programs say of a run before it begins, and of one that failed: every number against the scene and state.
#include <fmt/format.h>

#include <fstream>

#include "apps/bvp/columns.hpp"
#include "apps/bvp/probe_columns.hpp"
#include "apps/bvp/setup_text.hpp"
#include "apps/rve/setup_text.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "fem/session.hpp"
#include "tests/apps/refused.hpp"
#include "tests/helpers.hpp"

using namespace grus;
using namespace grus::app;
using grus::app::test::Scratch;
using grus::dem::PolyEllipsoid, grus::dem::State, grus::dem::Vec3;

namespace {

template <class Read>
auto scene_of(const std::string& text, Read&& read) {
  const Scratch scratch;
  const std::string file = scratch.path + "/scene.toml";
  std::ofstream(file) << text;
  return read(file, std::vector<std::string>{});
}

const std::string sand = R"(
title = "Sand"
[material.m]
youngs_modulus = 1e9
density = 2000
[packing]
kind = "simple-cubic"
layers = [2, 2, 2]
radius = { distribution = "constant", mean = "1 mm" }
[boundary]
kind = "periodic"
[loading]
kind = "uniaxial-strain"
strain_rate = 2
final_strain = 0.1
)";

/// Eight spheres in a cell, each of which touches its neighbours along three axes.
State eight(const dem::Model& model) {
  State s;
  for (int i = 0; i < 8; ++i)
    dem::test::add(s, PolyEllipsoid::sphere(1e-3), 1.99e-3 * Vec3(i & 1, i >> 1 & 1, i >> 2), 2000);
  s.boundary.cell.vectors = 3.98e-3 * dem::Mat3::Identity();
  dem::Team team(1);
  prepare(model, s, team);
  return s;
}

BvpScene block(const std::string& solve) {
  return scene_of("title = \"Block\"\nmesh.box = { size = [1, 1, 2], cells = [1, 2, 3] }\nsolve = " + solve +
                      "\nboundary = [{ where = \"z=min\", displacement = [0, 0, 0] }, { name = \"top\", where = "
                      "\"z=max\", pressure = 1 }]\nregion = [{ where = \"z>0\", material = \"elastic\", youngs_modulus "
                      "= 1e9, poissons_ratio = 0.2, density = 2000 }]\n",
                  read_bvp_scene);
}

BvpSetup setup_of(const BvpScene& scene) {
  BvpSetup setup;
  setup.problem = std::make_unique<fem::Problem>(MPI_COMM_SELF, std::get<fem::BoxMesh>(scene.mesh),
                                                 scene.discretisation, scene.boundaries);
  return setup;
}

}  // namespace

TEST_CASE("a test of grains is told with its sample, its step and how long it takes, each bound as it is known") {
  RveScene scene = scene_of(sand, read_rve_scene);
  State s = eight(scene.model);
  s.dt = 2e-6;
  scene.notes = {"one", "two"};
  const std::size_t contacts = dem::measure(scene.model, s).contacts;
  CHECK(contacts == 24);
  const double memory = (8 * 600.0 + 260.0 * static_cast<double>(s.contacts.size())) / 1e6;
  const double solid = 8 * 4 * dem::pi / 3 * 1e-9 / std::pow(3.98e-3, 3);
  const auto head = [&](double of, const std::string& piece) {
    return fmt::format(
        "Sand\n  grains {:.0f}   mean diameter 0.002 m   solid fraction {:.4f}   void ratio {:.4f}   bulk density "
        "{:.4g} "
        "g/cm^3   contacts {:.0f}{}\n  time step 2e-06 s   ",
        8 * of, solid, 1 / solid - 1, 2 * solid, 24 * of, piece);
  };
  const std::string notes = "\n  note: one\n  note: two";
  CHECK(setup_text(scene, s, 8, nullptr) ==
        head(1, "") + fmt::format("duration 0.05 s   steps at least about 2.5e+04   memory about {:.3g} MB", memory) +
            notes);
  Rehearsal found{.steps = 3e4, .seconds = 6.5, .part = 1, .larger = 3};
  CHECK(setup_text(scene, s, 80, &found) ==
        head(10, "   (from a piece of 8 grains)") +
            fmt::format("duration 0.05 s   steps 1.5e+04 to 6e+04   memory about {:.3g} MB\n  run time 32.5 s to 2 min "
                        "10 s (the whole test was rehearsed with grains 9 times as heavy)",
                        10 * memory) +
            notes);
  scene.notes.clear();
  found.part = 0.25;  // the rest is not known so well
  CHECK(setup_text(scene, s, 8, &found)
            .ends_with("\n  run time 2.2 s to 19.5 s (25 % of the test was rehearsed with grains 9 times as heavy)"));
  found.part = 0, found.steps = found.seconds = 0;
  CHECK(setup_text(scene, s, 8, &found).find("steps not known   ") != std::string::npos);
  CHECK(setup_text(scene, s, 8, &found).find("run time not known (") != std::string::npos);
  found = {.steps = 31234, .seconds = 6.5, .part = 1, .larger = 1};
  CHECK(setup_text(scene, s, 8, &found) ==
        head(1, "") + fmt::format("duration 0.05 s   steps about 3.12e+04   memory about {:.3g} MB\n  run time about "
                                  "6.5 s (the whole test was gone through)",
                                  memory));
  scene.test.final_stress = 1e6;
  CHECK(setup_text(scene, s, 8, nullptr).find("at most 0.05 s   steps at most about 2.5e+04 ") != std::string::npos);
  scene.model.numerics.time_step = 2e-6;
  CHECK(setup_text(scene, s, 8, nullptr).find("at most 0.05 s   steps at most about 2.5e+04 ") != std::string::npos);
  scene.test.stress_time = 0.01;  // of a ramp it is known when it ends
  CHECK(setup_text(scene, s, 8, nullptr).find("duration 0.05 s   steps about 2.5e+04 ") != std::string::npos);
  s.dt = 1;  // longer than the run
  CHECK(setup_text(scene, s, 8, nullptr).find("time step 0.05 s   duration 0.05 s   steps about 1 ") !=
        std::string::npos);
  s.boundary = {};
  CHECK(setup_text(scene, s, 8, nullptr).find("solid fraction") == std::string::npos);
}

TEST_CASE("of stages it is told how many rows they may have, and a duration where all have one") {
  const std::string staged =
      sand.substr(0, sand.find("[loading]")) +
      "[[stage]]\nkind = \"compress\"\nstrain_rate = 2\nrows = 5\nuntil = { strain = 0.1 }\n"
      "[[stage]]\nkind = \"compress\"\nstrain_rate = 2\nrows = 7\nuntil = { strain = 0.1, time = 0.01 }\n";
  RveScene scene = scene_of(staged, read_rve_scene);
  State s = eight(scene.model);
  s.dt = 2e-6;
  CHECK(setup_text(scene, s, 8, nullptr)
            .find("\n  stages 2   rows about 13   time step 2e-06 s   duration 0.06 s   steps "
                  "at least about 3e+04") != std::string::npos);
  CHECK_NOTHROW(refuse_endless(scene, s));
  scene.test.stages[1].until = {};
  scene.notes = {"a note"};
  CHECK(setup_text(scene, s, 8, nullptr)
            .ends_with("   (the time depends on when the stages meet their ends)\n  note: a note"));
  CHECK(setup_text(scene, s, 8, nullptr).find("time step 2e-06 s   memory about ") != std::string::npos);
  s.dt = 1e-300;  // what nobody knows the duration of is not refused for it
  CHECK_NOTHROW(refuse_endless(scene, s));
  RveScene plain = scene_of(sand, read_rve_scene);
  CHECK_THROWS_WITH(refuse_endless(plain, s),
                    Catch::Contains("loading: a time step of 1e-300 s would take 5e+298 steps to 0.05 s: stiffness"));
  s.dt = 2e-6;
  CHECK_NOTHROW(refuse_endless(plain, s));
}

TEST_CASE("a macro problem is told with its mesh, its grains, its memory and what its solver keeps to") {
  const fem::Session session;  // one a program
  Options options;
  options.threads = 3, options.scene = "block.toml";
  const std::string head = "Block\n  mesh 1 x 1 x 2 m   elements 6   Gauss points 48   ";
  BvpScene still = block("{ kind = \"quasi-static\", increments = 7, tolerance = 1e-4 }");
  BvpSetup setup = setup_of(still);
  CHECK(setup_text(still, setup, options, 2, 0) ==
        head +
            "with grains 0 (about 0 grains each, 0 packings)   increments 7   memory up to 0 MB   ranks 2 x threads "
            "3\n  residual to 0.0001");
  // Of grains: before they are made as many as the samples have, or the recipe says; then as many as there are.
  still.has_rve = true, still.variants = 2, still.notes = {"one", "two"};
  still.rve.response.quasi_static.unbalanced_force = 3e-3, still.rve.response.quasi_static.stress_change = 2e-3;
  still.unit_cells.resize(2, scene_of(sand, read_rve_scene));
  still.samples.resize(2);
  still.samples[1].emplace().state = eight(still.unit_cells[0].model);
  dem::test::add(still.samples[1]->state, PolyEllipsoid::sphere(1e-3), Vec3::Zero(), 2000);
  dem::test::add(still.samples[1]->state, PolyEllipsoid::sphere(1e-3), Vec3::Zero(), 2000);
  setup.points.all_rves = 1000;
  const std::string residual =
      "\n  residual to 0.003 (the larger of solve.tolerance, rve.unbalanced_force and rve.stress_change)\n  note: "
      "one\n  note: two";
  CHECK(setup_text(still, setup, options, 1, 0) ==
        head +
            "with grains 1000 (about 9 grains each, 2 packings)   increments 7   memory up to 72 MB   ranks 1 x "
            "threads 3" +
            residual);
  setup.states = {eight(still.unit_cells[0].model), still.samples[1]->state, still.samples[1]->state};
  CHECK(setup_text(still, setup, options, 1, 0).find("with grains 1000 (9 grains each") != std::string::npos);
  BvpScene quick = block("{ kind = \"explicit-dynamic\", duration = 0.0123 }");
  setup = setup_of(quick), setup.points.all_rves = 1000;
  quick.unit_cells = still.unit_cells, quick.samples = still.samples, quick.variants = 2;
  CHECK(setup_text(quick, setup, options, 1, 0) ==
        head +
            "with grains 1000 (about 9 grains each, 2 packings)   duration 0.0123 s   memory up to 45 MB   ranks 1 x "
            "threads 3");
  BvpScene steady =
      block("{ kind = \"explicit-quasi-static\", balance = 0.04, kinetic = 0.03, damping = 0.3, safety = 0.7 }");
  auto& e = *steady.explicit_statics;
  e.crossings = 6, e.inertial_number = 0;
  CHECK(setup_text(steady, setup, options, 1, 21) ==
        head +
            "with grains 1000 (about 0 grains each, 0 packings)   steps from 126   memory up to 0 MB   ranks 1 x "
            "threads 3\n  limits of the rate: unbalanced force 0.04 of what is applied, kinetic energy 0.03 of "
            "internal, inertial number of the RVEs their own; local damping 0.3, safety 0.7");
  e.inertial_number = 2e-3;
  CHECK(setup_text(steady, setup, options, 1, 21).find("number of the RVEs 0.002;") != std::string::npos);
  // What a run that failed says.
  BvpEnding ending;
  ending.text = "no rest", ending.time = 0.12345;
  for (const int status : {finished, interrupted, out_of_time, refused}) {
    ending.status = status;
    CHECK(failure_text(still, options, ending).empty());
  }
  ending.status = failed;
  CHECK(failure_text(still, options, ending) == "block.toml: no rest");
  ending.status = unstable;
  CHECK(failure_text(still, options, ending) ==
        "block.toml: load factor 0.1235: no rest; more solve.increments, tighter rve.unbalanced_force or a larger unit "
        "cell may help, or explicit-quasi-static");
  CHECK(failure_text(quick, options, ending) ==
        "block.toml: time 0.1235: no rest; a smaller solve.safety or another unit cell may help");
  CHECK(failure_text(steady, options, ending) ==
        "block.toml: load factor 0.1235: no rest; larger limits in [solve], a larger unit cell or rve.on_failure = "
        "\"elastic\" may help");
  ending.text = "regularisation_J has fallen";
  CHECK(failure_text(steady, options, ending).ends_with("has fallen; a larger regularisation.memory may help"));
  // Ground that its RVEs cannot bear, at the mean of three stresses.
  const double most = dem::unbearable_pressure(still.unit_cells[0].model, 1e-3);
  const auto told = [&](double part, bool stressed) {
    Start start{1, stressed, {part * most, 0.5 * part * most, 1.5 * part * most}};
    check_starts(still, {Start{}, start});
  };
  CHECK_NOTHROW(told(0.99, true));
  CHECK_NOTHROW(told(1.01, false));
  CHECK_THROWS_WITH(told(1.01, true), Catch::Contains("scene.toml: initial_stress: "));

  // Columns of a macro problem and of its probes, by what there is.
  const auto names = [&](const BvpScene& scene, bool bonded) {
    const auto all = names_of(macro_columns({scene, *setup.problem, bonded}));
    CHECK(std::set<std::string>(all.begin(), all.end()).size() == all.size());
    return std::set<std::string>(all.begin(), all.end());
  };
  still.regions.clear();
  const auto plain = names(still, false);
  for (const char* name :
       {"time_s", "reaction_top_x_N", "moved_top_z_m", "mean_stress_zz_Pa", "mean_strain_xy", "q_Pa"})
    CHECK(plain.count(name) == 1);
  CHECK(plain.size() == 32 + 10 + 2 * 6);
  CHECK(names(still, true).size() == plain.size() + 1);
  still.regions = quick.regions;
  CHECK(names(still, false).size() == plain.size() + 12);
  CHECK(names(quick, false).size() == plain.size() + 3);
  CHECK(names(steady, false).size() == plain.size() + 3 + 8);
  steady.regularisation.emplace();
  CHECK(names(steady, false).size() == plain.size() + 3 + 8 + 1);
  MacroRow row;
  for (std::size_t k = 0; k < 6; ++k) {
    row.strain[k] = 10.0 + static_cast<double>(k), row.stress[k] = 20.0 + static_cast<double>(k);
    row.grains_strain[k] = 30.0 + static_cast<double>(k), row.grains_stress[k] = 40.0 + static_cast<double>(k);
  }
  const auto columns = macro_columns({still, *setup.problem, false});
  row.reaction = {1, 2, 3, 4, 5, 6}, row.moved = {51, 52, 53, 54, 55, 56};
  fem::MacroEnergy energy;
  energy.external = 7, energy.internal = 8, row.energy = &energy;
  const auto values = values_of(columns, row);
  std::map<std::string, double> said;
  for (std::size_t c = 0; c < columns.size(); ++c) said[columns[c].name] = values[c];
  const char* parts[] = {"xx", "yy", "zz", "yz", "xz", "xy"};
  for (int k = 0; k < 6; ++k) {
    const std::string part = parts[k];
    CHECK((said["mean_strain_" + part] == 10 + k && said["mean_stress_" + part + "_Pa"] == 20 + k));
    CHECK((said["grains_strain_" + part] == 30 + k && said["grains_stress_" + part + "_Pa"] == 40 + k));
  }
  CHECK((said["reaction_top_x_N"] == 4 && said["reaction_top_z_N"] == 6 && said["moved_top_y_m"] == 55));
  CHECK((said["macro_external_J"] == 7 && said["macro_internal_J"] == 8));
  const auto probe = [](bool place, bool cell, bool grading) {
    return probe_columns("p", {place, cell, grading}).size();
  };
  CHECK((probe(false, false, false) == 12 && probe(true, false, false) == 15 && probe(true, true, true) == 15));
  CHECK((probe(false, true, false) == 16 && probe(false, true, true) == 21 && probe(false, false, true) == 12));
  ProbeRow of;
  of.strain = row.strain, of.stress = row.stress, of.void_ratio = 1, of.coordination = 2, of.grains = 3,
  of.breakages = 4;
  of.diameter = {5, 6, 7}, of.einav = 8, of.fines = 9;
  const auto all = probe_columns("p", {false, true, true});
  CHECK(values_of(all, of) ==
        std::vector<double>{10, 11, 12, 13, 14, 15, 20, 21, 22, 23, 24, 25, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  CHECK((all[0].name == "probe_p_strain_xx" && all[11].name == "probe_p_stress_xy_Pa" &&
         all[18].name == "probe_p_d90_m"));
  // How long it takes: whole rounds of all workers; starts of one packing are packed once.
  CHECK(preparation_text(7, 2, 3, {10, 0.5}) ==
        "  preparation: about 11.5 s (7 starts of 2 packings; 10 s a packing, 0.5 s a start)");
  CHECK(preparation_text(1, 5, 3, {10, 0.5}) ==
        "  preparation: about 10.5 s (1 starts of 1 packings; 10 s a packing, 0.5 s a start)");
  RunEstimate run;
  run.low = 5, run.high = 125, run.text = "9 steps", run.rest = "more";
  CHECK(run_text(run) == "  run: 5.0 s to 2 min 05 s (9 steps); more");
  run.low = 125, run.high = 0;
  CHECK(run_text(run) == "  run: at least about 2 min 05 s (9 steps); more");
}
