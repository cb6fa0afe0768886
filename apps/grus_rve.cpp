// SPDX-License-Identifier: LGPL-3.0-or-later
// grus-rve: one DEM test, standalone.
#include <fmt/format.h>

#include <filesystem>

#include "apps/error_estimates.hpp"
#include "apps/folder.hpp"
#include "apps/grading_states.hpp"
#include "apps/run.hpp"
#include "apps/rve_history.hpp"
#include "apps/scene/prepare_sample.hpp"
#include "apps/scene/sample_scene.hpp"
#include "dem/bond/cohesive.hpp"
#include "dem/io/archive.hpp"
#include "dem/io/checkpoint.hpp"
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
  Frames(const Options& options, int count, double duration)
      : folder_(options.directory), count_(count), every_(count > 1 ? duration / (count - 1) : duration) {
    if (count_ > 0) std::filesystem::create_directories(folder_ / "grains");
  }
  nlohmann::json series() const { return series_; }
  void restore(const nlohmann::json& series) { series_ = series.get<decltype(series_)>(); }
  void write_if_due(const dem::State& state) {
    if (static_cast<int>(series_.size()) >= count_ ||
        state.time < every_ * static_cast<double>(series_.size()) * (1 - 1e-9))
      return;
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
  for (const auto& spring : s.bonds.cohesive.row) whole += 0.5 * spring.peak * spring.rupture - dem::dissipated(spring);
  return {{"work_J", l.work},
          {"kinetic_J", m.kinetic},
          {"elastic_J", m.elastic},
          {"start_J", l.start},
          {"friction_J", l.friction},
          {"damping_J", l.damping},
          {"local_damping_J", l.local_damping},
          {"fracture_J", l.fracture},
          {"split_elastic_J", l.split},
          {"fines_kinetic_J", l.fines.kinetic},
          {"fracture_left_in_springs_J", whole},
          {"reshape_J", l.reshape},
          {"split_added_J", l.split_added},
          {"fracture_area_m2", l.fracture_area},
          {"split_force_residual_N", l.residual_force},
          {"energy_unexplained_J", l.unexplained},
          {"energy_error", dem::energy_error(l, m.kinetic + m.elastic)}};
}

/// `grains`: of the whole sample, where the state is a piece of it. `wall_estimate`: s, of the whole; 0: none.
void print_setup(const RveScene& scene, const dem::State& s, double grains, double wall_estimate) {
  const dem::Measurement m = dem::measure(scene.model, s);
  const double whole = grains / static_cast<double>(s.grains.size());
  const std::string piece = whole != 1 ? fmt::format("   (from a piece of {} grains)", s.grains.size()) : "";
  fmt::print(
      "{}\n  grains {:.0f}   mean diameter {:.4g} m   solid fraction {:.4f}   bulk density {:.4g} g/cm^3   contacts "
      "{:.0f}{}\n",
      scene.title, grains, dem::mean_diameter(s.grains), m.solid_fraction,
      m.volume > 0 ? dem::total_mass(s.grains) / m.volume / 1000 : 0.0, whole * static_cast<double>(m.contacts), piece);
  const double bytes =
      whole * (static_cast<double>(s.grains.size()) * 600 + static_cast<double>(s.contacts.size()) * 260);
  fmt::print("  time step {:.3g} s   duration {:.4g} s   steps about {:.3g}   memory about {:.3g} MB", s.dt,
             scene.test.duration, scene.test.duration / s.dt, bytes / 1e6);
  if (wall_estimate > 0) fmt::print("   run time about {} (at the initial time step)", duration_text(wall_estimate));
  fmt::print("\n");
  for (const auto& note : scene.notes) fmt::print("  note: {}\n", note);
}

/// Steps of a grain that no machine of today gets through in months; with few grains a step costs as much as with a
/// thousand.
constexpr double most_grain_steps = 1e14;

void refuse_endless(const RveScene& scene, const dem::State& s) {
  const double steps = scene.test.duration / s.dt;
  if (!(steps * std::max(1000.0, static_cast<double>(s.grains.size())) < most_grain_steps))
    throw dem::InputError(
        fmt::format("{}: loading: a time step of {:.3g} s would take {:.3g} steps to {:.3g} s: stiffness, density, "
                    "size or speed of the grains, or the rate, is out of all bounds",
                    scene.file, s.dt, steps, scene.test.duration));
}

/// What a run carries besides its state.
struct Course {
  dem::Mat3 initial_cell = dem::Mat3::Zero();
  dem::Vec3 initial_size = dem::Vec3::Zero();
  std::uint64_t row = 0;
  double peak = 0, wall = 0, grain_steps = 0;
  ErrorEstimates errors;

  template <class A>
  static void archive(A& a, auto& c) {
    a.plain(c.initial_cell), a.plain(c.initial_size), a.plain(c.row), a.plain(c.peak), a.plain(c.wall),
        a.plain(c.grain_steps), ErrorEstimates::archive(a, c.errors);
  }
};

void save_checkpoint(const Options& options, const RveScene& scene, const dem::State& state, const Course& course,
                     const History& history, const Frames& frames, const GradingStates& gradings) {
  dem::Saver saver;
  Course::archive(saver, course);
  const nlohmann::json about{{"program", "grus-rve"},
                             {"scene", scene.record},
                             {"rows", history.rows()},
                             {"frames", frames.series()},
                             {"gradings", gradings.written()}};
  dem::write_checkpoint(options.directory + "/checkpoint.h5", about.dump(), [&](const dem::TakePart& take) {
    take(dem::bytes_of(state)), take(saver.take()), take(history.text()), take(gradings.text());
  });
}

/// Refuses what is not a checkpoint of this scene.
dem::Checkpoint find_checkpoint(const Options& options, const RveScene& scene) {
  const std::string path = options.directory + "/checkpoint.h5";
  dem::Checkpoint kept = dem::read_checkpoint(path);
  const nlohmann::json about = nlohmann::json::parse(kept.about);
  if (about.value("program", "") != "grus-rve" || kept.parts.size() != 4)
    throw dem::InputError(path + ": not a checkpoint of grus-rve");
  if (about["scene"] != scene.record)
    throw dem::InputError(path + ": checkpoint of another scene or other settings; give the same file and --set");
  return kept;
}

dem::State take_up(const dem::Checkpoint& kept, Course& course, History& history, Frames& frames,
                   GradingStates& gradings) {
  const nlohmann::json about = nlohmann::json::parse(kept.about);
  dem::State state = dem::state_of(kept.parts[0]);
  dem::Loader loader(kept.parts[1]);
  Course::archive(loader, course);
  history.restore(kept.parts[2], about["rows"]);
  gradings.restore(kept.parts[3], about["gradings"]);
  frames.restore(about["frames"]);
  return state;
}

/// --check: what a run would be like, from a piece of the sample where that is large.
int check(const Options& options, RveScene& scene, dem::Team& team) {
  const double all = scene.grains();
  const bool piece = make_smaller(scene);
  Progress progress(options.quiet);
  dem::State state =
      prepare_sample(scene, team, [&](double done, const char* what) { return progress.watch(done, what); });
  dem::begin_loading(scene.model, state, scene.test.loading);
  refuse_endless(scene, state);
  dem::State probe = state;
  const Clock timer;
  while (probe.steps < 50) {
    dem::update_time_step(scene.model, probe);
    dem::run_steps(scene.model, probe, 2, team);
  }
  const double grains = piece ? all : static_cast<double>(state.grains.size());
  print_setup(scene, state, grains,
              timer.wall() / 50 * scene.test.duration / probe.dt * grains / static_cast<double>(state.grains.size()));
  return finished;
}

int run(const Options& options) {
  const Clock clock;
  RveScene scene = read_rve_scene(options.scene, options.overrides);
  if (options.columns) {
    for (const auto& name : rve_columns(scene, scene.state)) fmt::print("{}\n", name);
    return finished;
  }
  dem::Team team(options.threads);
  if (options.check) return check(options, scene, team);
  dem::Checkpoint kept;
  if (options.resume) kept = find_checkpoint(options, scene);
  check_folder(options);
  dem::State state;
  {
    Progress progress(options.quiet);
    auto watch = [&](double done, const char* what) { return progress.watch(done, what); };
    if (options.resume) {
      make_sample(scene, team,
                  [&](double done) { return watch(done, "packing"); });  // what the sample was at first, for gradings
    } else {
      state = prepare_sample(scene, team, watch);
      dem::begin_loading(scene.model, state, scene.test.loading);
      refuse_endless(scene, state);
    }
  }
  const Folder made(options);
  if (!options.quiet && !options.resume) print_setup(scene, state, static_cast<double>(state.grains.size()), 0);
  const double ready = clock.wall();

  const std::filesystem::path folder = options.directory;
  History history((folder / "history.csv").string(), rve_columns(scene, options.resume ? scene.state : state));
  Frames frames(options, scene.output.frames, scene.test.duration);
  GradingStates gradings(options.directory, scene);
  Course course;
  course.initial_cell = state.boundary.cell.vectors, course.initial_size = scene.test.loading.initial_size;
  if (options.resume) {
    state = take_up(kept, course, history, frames, gradings);
    scene.test.loading.initial_size = course.initial_size;
    if (!options.quiet)
      fmt::print("{}\n  going on from t = {:.4g} s, {} grains\n", scene.title, state.time, state.grains.size());
  }
  Progress progress(options.quiet);
  dem::Measurement m = dem::measure(scene.model, state);

  int status = finished;
  std::string ending = "finished";
  double saved = clock.wall();
  const double earlier = course.wall;
  const auto rows =
      static_cast<std::uint64_t>(std::ceil(scene.test.duration / scene.output.history_interval * (1 - 1e-9)));
  try {
    dem::check_sanity(scene.model, state);
    if (!options.resume) {
      history.add(rve_row(scene, state, m, course.initial_cell));
      frames.write_if_due(state);
      gradings.write_if_due(state);
    }
    double axial = axial_stress(scene, state, m), error = dem::energy_error(state.ledger, m.kinetic + m.elastic);
    auto stand = [&] {  // of a moment between rows: stress and error are the last row's
      course.wall = earlier + clock.wall() - ready;
      progress.show(state.time / scene.test.duration,
                    fmt::format("t {:.4g} s  strain {:.4f}  stress {:.3g} MPa  grains {}  broken {}  energy error "
                                "{:.2f} %  {:.3g} steps/s",
                                state.time, state.time * scene.test.strain_rate, axial / 1e6, state.grains.size(),
                                state.ledger.breakages, 100 * error, static_cast<double>(state.steps) / course.wall));
    };
    auto due = [&] { return interruption_asked() || clock.wall() - saved > scene.output.checkpoint_interval; };
    for (std::uint64_t row = course.row + 1; row <= rows; ++row) {
      const double until = row == rows ? scene.test.duration : static_cast<double>(row) * scene.output.history_interval;
      bool stop = false;
      for (bool there = false; !there && !stop;) {
        const std::uint64_t before = state.steps;
        there = dem::load(scene.model, state, scene.test.loading, until, team, [&](double) { return stand(), !due(); });
        course.grain_steps += static_cast<double>(state.steps - before) * static_cast<double>(state.grains.size());
        if (there) {
          m = dem::measure(scene.model, state);
          dem::check_sanity(scene.model, state);
          history.add(rve_row(scene, state, m, course.initial_cell));
          frames.write_if_due(state);
          gradings.write_if_due(state);
          axial = axial_stress(scene, state, m), error = dem::energy_error(state.ledger, m.kinetic + m.elastic);
          course.peak = std::max(course.peak, axial);
          course.errors.add(state, m);
          course.row = row;
          stand();
          history.save(2);
          if (scene.test.final_stress && axial >= *scene.test.final_stress) break;
        }
        if (!due()) continue;
        stop = interruption_asked();
        save_checkpoint(options, scene, state, course, history, frames, gradings);
        saved = clock.wall();
      }
      if (stop) {
        status = interrupted, ending = "interrupted; --resume goes on from checkpoint.h5";
        break;
      }
      if (scene.test.final_stress && axial >= *scene.test.final_stress) break;
    }
  } catch (const dem::Unstable& e) {
    status = unstable, ending = e.what();
  } catch (const std::exception& e) {  // of the system: what there is may still be kept
    status = failed, ending = e.what();
  }
  const double wall = clock.wall();
  nlohmann::json summary = provenance();
  summary["title"] = scene.title;
  if (!scene.notes.empty()) summary["notes"] = scene.notes;
  summary["scene_file"] = std::filesystem::path(scene.file).filename().string();
  summary["scene"] = scene.record;
  summary["status"] = status;
  summary["ending"] = ending;
  summary["seed"] = scene.model.seed;
  summary["threads"] = options.threads;
  summary["counts"] = {{"grains_start", scene.state.grains.size()},
                       {"grains", state.grains.size()},
                       {"breakages", state.ledger.breakages},
                       {"bonds_broken", state.ledger.bonds_broken},
                       {"steps", state.steps},
                       {"grain_steps", course.grain_steps},
                       {"history_rows", history.rows()}};
  if (const double bulk = dem::bulk_volume(scene.state.boundary); bulk > 0)
    summary["sample"] = {{"bulk_density_kg_m3", dem::total_mass(scene.state.grains) / bulk},
                         {"solid_fraction", dem::solid_volume(scene.state.grains) / bulk}};
  summary["mass"] = {{"start_kg", dem::total_mass(scene.state.grains)},
                     {"grains_kg", dem::total_mass(state.grains)},
                     {"lost_kg", state.ledger.fines.mass}};
  if (scene.model.breakable()) {
    const dem::Fines& f = state.ledger.fines;
    auto vector = [](const dem::Vec3& v) { return nlohmann::json{v.x(), v.y(), v.z()}; };
    summary["fines"] = {{"mass_kg", f.mass},
                        {"kinetic_J", f.kinetic},
                        {"momentum_kg_m_s", vector(f.momentum)},
                        {"angular_momentum_kg_m2_s", vector(f.angular_momentum)}};
  }
  summary["energy"] = ledger_json(state, m);
  summary["errors"] = course.errors.json(state);
  if (state.ledger.local_damping > 0)
    summary["errors"]["local_damping"] =
        state.ledger.local_damping / dem::energy_scale(state.ledger, m.kinetic + m.elastic);
  summary["errors"]["packing_overlap"] = scene.packing_overlap;
  summary["results"] = {
      {"peak_axial_stress_Pa", course.peak}, {"final_time_s", state.time}, {"final_void_ratio", m.void_ratio}};
  summary["seconds"] = {{"preparation_wall", ready}, {"loading_wall", earlier + wall - ready}, {"cpu", Clock::cpu()}};
  try {
    history.save();
    dem::write_whole((folder / "summary.json").string(), summary.dump(2) + "\n");
  } catch (const std::exception&) {  // of one fault one line
    if (status != failed) throw;
  }

  progress.finish(
      fmt::format("{}: t {:.5g} s, peak stress {:.4g} MPa, {} -> {} grains, {} breakages, mass lost {:.2f} %, worst "
                  "energy error {:.2f} %, "
                  "{} steps in {} ({})",
                  status == finished      ? "finished"
                  : status == interrupted ? "interrupted"
                                          : "stopped",
                  state.time, course.peak / 1e6, scene.state.grains.size(), state.grains.size(), state.ledger.breakages,
                  100 * state.ledger.fines.mass / dem::total_mass(scene.state.grains), 100 * course.errors.energy.worst,
                  state.steps, duration_text(earlier + wall - ready), options.directory));
  if (status == unstable || status == failed)
    fmt::print(stderr, "{}\n", one_line(fmt::format("{}: {}", options.scene, ending)));
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  return run_command(argc, argv, "grus-rve",
                     "One DEM test of breakable grains: SHPB, oedometer, triaxial, single-grain crushing, free motion.",
                     run);
}
