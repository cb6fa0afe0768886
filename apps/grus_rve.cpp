// SPDX-License-Identifier: LGPL-3.0-or-later
// grus-rve: one DEM test, standalone.
#include <fmt/format.h>

#include <filesystem>

#include "apps/grading_states.hpp"
#include "apps/prepare_sample.hpp"
#include "apps/run.hpp"
#include "apps/rve_history.hpp"
#include "dem/bond/cohesive.hpp"
#include "dem/io/frames.hpp"
#include "dem/io/vtkhdf.hpp"
#include "dem/io/whole_file.hpp"
#include "dem/rve/step.hpp"

using namespace grus;
using namespace grus::app;

namespace {

/// Grain surfaces at evenly spaced times, the first at the start.
class Frames {
public:
  Frames(const Options& options, int count, double duration) : folder_(options.directory), count_(count), every_(count > 1 ? duration / (count - 1) : duration) {
    if (count_ > 0) std::filesystem::create_directories(folder_ / "grains");
  }
  void write_if_due(const dem::State& state) {
    if (static_cast<int>(series_.size()) >= count_ || state.time < every_ * static_cast<double>(series_.size()) * (1 - 1e-9)) return;
    const std::string name = fmt::format("grains/grains_{:05}.hdf", series_.size());
    dem::write_grains((folder_ / name).string(), state);
    series_.emplace_back(name, state.time);
    dem::write_series((folder_ / "grains.hdf.series").string(), series_);
  }

private:
  std::filesystem::path folder_;
  int count_;
  double every_;
  std::vector<std::pair<std::string, double>> series_;
};

nlohmann::json ledger_json(const dem::State& s, const dem::Measurement& m) {
  const dem::Ledger& l = s.ledger;
  double whole = 0;  // with fracture_J this is G_c times the area made
  for (const auto& spring : s.bonds) whole += 0.5 * spring.peak * spring.rupture - dem::dissipated(spring);
  return {{"work_J", l.work},         {"kinetic_J", m.kinetic},       {"elastic_J", m.elastic},
          {"start_J", l.start},       {"friction_J", l.friction},     {"damping_J", l.damping},
          {"fracture_J", l.fracture}, {"split_elastic_J", l.split},   {"fines_kinetic_J", l.fines.kinetic},
          {"fracture_left_in_springs_J", whole}, {"reshape_J", l.reshape},   {"split_added_J", l.split_added}, {"fracture_area_m2", l.fracture_area}, {"split_force_residual_N", l.residual_force},
          {"energy_error", dem::energy_error(l, m.kinetic + m.elastic)}};
}

void print_setup(const RveScene& scene, const dem::State& s, double wall_estimate) {
  const dem::Measurement m = dem::measure(scene.model, s);
  fmt::print("{}\n  grains {}   mean diameter {:.4g} m   solid fraction {:.4f}   bulk density {:.4g} g/cm^3   contacts {}\n", scene.title, s.grains.size(),
             dem::mean_diameter(s.grains), m.solid_fraction, m.volume > 0 ? dem::total_mass(s.grains) / m.volume / 1000 : 0.0, m.contacts);
  const double bytes = static_cast<double>(s.grains.size()) * 600 + static_cast<double>(s.contacts.size()) * 260;
  fmt::print("  time step {:.3g} s   duration {:.4g} s   steps about {:.3g}   memory about {:.3g} MB", s.dt, scene.test.duration,
             scene.test.duration / s.dt, bytes / 1e6);
  if (wall_estimate > 0) fmt::print("   run time about {} (at the initial time step)", duration_text(wall_estimate));
  fmt::print("\n");
}

int run(const Options& options) {
  const Clock clock;
  RveScene scene = read_rve_scene(options.scene, options.overrides);
  dem::Team team(options.threads);
  if (!options.check) make_folder(options);
  dem::State state = prepare_sample(scene, team);
  dem::begin_loading(scene.model, state, scene.test.loading);
  if (options.check) {
    dem::State probe = state;
    const Clock timer;
    while (probe.steps < 50) {
      dem::update_time_step(scene.model, probe);
      dem::run_steps(scene.model, probe, 2, team);
    }
    print_setup(scene, state, timer.wall() / 50 * scene.test.duration / probe.dt);
    return finished;
  }
  if (!options.quiet) print_setup(scene, state, 0);
  if (scene.output.wants_checkpoints) fmt::print(stderr, "{}: note: output.checkpoint_interval: this version writes no checkpoints\n", options.scene);
  const double ready = clock.wall();

  const dem::Mat3 initial_cell = state.boundary.cell.vectors;
  const std::filesystem::path folder = options.directory;
  History history((folder / "history.csv").string(), rve_columns(scene, state));
  Frames frames(options, scene.output.frames, scene.test.duration);
  GradingStates gradings(options.directory, scene);
  Progress progress(options.quiet);
  dem::Measurement m = dem::measure(scene.model, state);
  history.add(rve_row(scene, state, m, initial_cell));
  frames.write_if_due(state);
  gradings.write_if_due(state);

  int status = finished;
  std::string ending = "finished";
  double peak = 0, worst_error = 0;
  const auto rows = static_cast<std::uint64_t>(std::ceil(scene.test.duration / scene.output.history_interval * (1 - 1e-9)));
  try {
    for (std::uint64_t row = 1; row <= rows; ++row) {
      const double until = row == rows ? scene.test.duration : static_cast<double>(row) * scene.output.history_interval;
      dem::load(scene.model, state, scene.test.loading, until - state.time, team);
      m = dem::measure(scene.model, state);
      dem::check_sanity(scene.model, state);
      history.add(rve_row(scene, state, m, initial_cell));
      history.save(2);
      frames.write_if_due(state);
      gradings.write_if_due(state);
      const double axial = axial_stress(scene, state, m), error = dem::energy_error(state.ledger, m.kinetic + m.elastic);
      peak = std::max(peak, axial), worst_error = std::max(worst_error, std::abs(error));
      progress.show(state.time / scene.test.duration,
                    fmt::format("t {:.4g} s  strain {:.4f}  stress {:.3g} MPa  grains {}  broken {}  energy error {:.2f} %  {:.3g} steps/s", state.time,
                                state.time * scene.test.strain_rate, axial / 1e6, state.grains.size(), state.ledger.breakages, 100 * error,
                                static_cast<double>(state.steps) / (clock.wall() - ready)));
      if (scene.test.final_stress && axial >= *scene.test.final_stress) break;
      if (interruption_asked()) {
        status = interrupted, ending = "interrupted";
        break;
      }
    }
  } catch (const dem::Unstable& e) {
    status = unstable, ending = e.what();
  }
  history.save();
  const double wall = clock.wall();
  nlohmann::json summary = provenance();
  summary["title"] = scene.title;
  summary["scene_file"] = std::filesystem::path(scene.file).filename().string();
  summary["scene"] = scene.record;
  summary["status"] = status;
  summary["ending"] = ending;
  summary["seed"] = scene.model.seed;
  summary["threads"] = options.threads;
  summary["counts"] = {{"grains_start", scene.state.grains.size()}, {"grains", state.grains.size()}, {"breakages", state.ledger.breakages},
                       {"bonds_broken", state.ledger.bonds_broken}, {"steps", state.steps}, {"history_rows", history.rows()}};
  if (const double bulk = dem::bulk_volume(scene.state.boundary); bulk > 0)
    summary["sample"] = {{"bulk_density_kg_m3", dem::total_mass(scene.state.grains) / bulk}, {"solid_fraction", dem::solid_volume(scene.state.grains) / bulk}};
  summary["mass"] = {{"start_kg", dem::total_mass(scene.state.grains)}, {"grains_kg", dem::total_mass(state.grains)}, {"lost_kg", state.ledger.fines.mass}};
  summary["energy"] = ledger_json(state, m);
  summary["errors"] = {{"worst_energy_error", worst_error}, {"packing_overlap", scene.packing_overlap}};
  summary["results"] = {{"peak_axial_stress_Pa", peak}, {"final_time_s", state.time}, {"final_void_ratio", m.void_ratio}};
  summary["seconds"] = {{"preparation_wall", ready}, {"loading_wall", wall - ready}, {"cpu", Clock::cpu()}};
  dem::write_whole((folder / "summary.json").string(), summary.dump(2) + "\n");

  progress.finish(fmt::format("{}: t {:.5g} s, peak stress {:.4g} MPa, {} -> {} grains, {} breakages, mass lost {:.2f} %, worst energy error {:.2f} %, "
                              "{} steps in {} ({})",
                              status == finished ? "finished" : status == interrupted ? "interrupted" : "stopped", state.time, peak / 1e6,
                              scene.state.grains.size(), state.grains.size(), state.ledger.breakages,
                              100 * state.ledger.fines.mass / dem::total_mass(scene.state.grains), 100 * worst_error, state.steps, duration_text(wall - ready),
                              options.directory));
  if (status == unstable) fmt::print(stderr, "{}: {}\n", options.scene, ending);
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  return run_command(argc, argv, "grus-rve", "One DEM test of breakable grains: SHPB, oedometer, triaxial, single-grain crushing, free motion.", run);
}
