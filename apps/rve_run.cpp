// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve_run.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "apps/bond_results.hpp"
#include "apps/rve_history.hpp"
#include "dem/bond/cohesive.hpp"
#include "dem/io/archive.hpp"
#include "dem/io/whole_file.hpp"
#include "dem/rve/bonded.hpp"
#include "dem/rve/check_state.hpp"
#include "dem/rve/crushing.hpp"
#include "dem/rve/grading.hpp"
#include "dem/rve/step.hpp"

namespace grus::app {
namespace {

std::string checkpoint_of(const Options& options) { return options.directory + "/checkpoint.h5"; }

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

}  // namespace

dem::Checkpoint find_checkpoint(const Options& options, const RveScene& scene) {
  const std::string path = checkpoint_of(options);
  dem::Checkpoint kept = dem::read_checkpoint(path);
  const nlohmann::json about = nlohmann::json::parse(kept.about, nullptr, false);
  if (!about.is_object() || about.value("program", "") != "grus-rve" || kept.parts.size() != 4)
    throw InputError(path + ": not a checkpoint of grus-rve");
  if (about.value("scene", nlohmann::json{}) != scene.record)
    throw InputError(path + ": checkpoint of another scene or other settings; give the same file and --set");
  return kept;
}

RveRun::RveRun(const Options& options, RveScene& scene, dem::Team& team, dem::State state, const dem::Checkpoint& kept,
               const Clock& clock, double ready)
    : options_(options),
      scene_(scene),
      team_(team),
      clock_(clock),
      ready_(ready),
      state_(std::move(state)),
      history_((std::filesystem::path(options.directory) / "history.csv").string(),
               rve_columns(scene, options.resume ? scene.state : state_)),
      frames_(options, scene.output, scene.test.duration),
      gradings_(options.directory, scene),
      progress_(options),
      limit_(options.started, options.max_time) {
  course_.initial_cell = state_.boundary.cell.vectors, course_.initial_size = scene.test.loading.initial_size;
  if (options.resume) take_up(kept);
  now_ = dem::survey(scene.model, state_, team_);
  saved_ = clock.wall(), earlier_ = course_.wall;
}

void RveRun::take_up(const dem::Checkpoint& kept) {
  const std::string path = checkpoint_of(options_) + ": ";
  const nlohmann::json about = nlohmann::json::parse(kept.about);
  try {
    state_ = dem::state_of(kept.parts[0]);
    dem::check_state(scene_.model, state_);
    dem::Loader loader(kept.parts[1]);
    Course::archive(loader, course_);
    history_.restore(kept.parts[2], about.at("rows"));
    gradings_.restore(kept.parts[3], about.at("gradings"));
    frames_.restore(about.at("frames"));
    check_course(loader.at_end());
  } catch (const InputError& e) {
    throw InputError(path + e.what());
  } catch (const nlohmann::json::exception&) {
    throw InputError(path + "checkpoint is damaged: what it tells of itself");
  }
  scene_.test.loading.initial_size = course_.initial_size;
  say(options_,
      fmt::format("{}\n  going on from t = {:.4g} s, {} grains", scene_.title, state_.time, state_.grains.size()));
}

/// The course, its rows and the state belong together.
void RveRun::check_course(bool whole) const {
  const double row = static_cast<double>(course_.row), every = scene_.output.history_interval, slack = 1e-6 * every;
  const auto& c = course_;
  const bool finite = c.initial_cell.allFinite() && c.initial_size.allFinite() && std::isfinite(c.peak + c.intact) &&
                      std::isfinite(c.reading + c.overfull) && c.wall >= 0 && std::isfinite(c.wall) &&
                      c.grain_steps >= 0 && std::isfinite(c.grain_steps);
  const auto lines = static_cast<std::size_t>(std::count(history_.text().begin(), history_.text().end(), '\n'));
  if (!whole || !finite || history_.rows() != course_.row + 1 || lines != history_.rows() + 1 ||
      !(state_.time >= row * every - slack || state_.time >= scene_.test.duration - slack) ||
      !(state_.time <= (row + 1) * every + slack && state_.time <= scene_.test.duration + slack))
    throw InputError("checkpoint is damaged: rows and time do not match");
}

void RveRun::save_checkpoint() {
  const Clock writing;
  dem::Saver saver;
  Course::archive(saver, course_);
  const nlohmann::json about{{"program", "grus-rve"},
                             {"scene", scene_.record},
                             {"rows", history_.rows()},
                             {"frames", frames_.series()},
                             {"gradings", gradings_.written()}};
  dem::write_checkpoint(checkpoint_of(options_), about.dump(), [&](const dem::TakePart& take) {
    take(dem::bytes_of(state_));
    take(saver.take());
    take(history_.text());
    take(gradings_.text());
  });
  saved_ = clock_.wall();
  limit_.wrote(writing.wall());
  if (checkpoint_asked()) progress_.note(fmt::format("  checkpoint written at t = {:.4g} s, as asked", state_.time));
  checkpoint_written();
}

bool RveRun::due() {
  over_ = limit_.over() || over_;
  return over_ || interruption_asked() || checkpoint_asked() ||
         clock_.wall() - saved_ > scene_.output.checkpoint_interval;
}

/// Of a moment between rows: stress and error are the last row's.
void RveRun::show() {
  course_.wall = earlier_ + clock_.wall() - ready_;
  progress_.show(state_.time / scene_.test.duration,
                 fmt::format("t {:.4g} s  strain {:.4f}  stress {:.3g} MPa  grains {}  broken {}  energy error "
                             "{:.2f} %  {:.3g} steps/s",
                             state_.time, state_.time * scene_.test.strain_rate, axial_ / 1e6, state_.grains.size(),
                             state_.ledger.breakages, 100 * error_, static_cast<double>(state_.steps) / course_.wall));
}

void RveRun::write_row() {
  history_.add(rve_row(scene_, state_, now_, course_.initial_cell));
  frames_.write_if_due(state_);
  gradings_.write_if_due(state_);
}

/// Until the row is written; false: the run ends here.
bool RveRun::go_to_row(std::uint64_t row, double until) {
  while (true) {
    const std::uint64_t before = state_.steps;
    const bool there =
        dem::load(scene_.model, state_, scene_.test.loading, until, team_, [&](double) { return show(), !due(); });
    course_.grain_steps += static_cast<double>(state_.steps - before) * static_cast<double>(state_.grains.size());
    if (there) {
      now_ = dem::survey(scene_.model, state_, team_);
      dem::check_sanity(scene_.model, state_, now_.kinetic + now_.elastic, now_.deepest);
      write_row();
      axial_ = axial_stress(scene_, state_, now_);
      error_ = dem::energy_error(state_.ledger, now_.kinetic + now_.elastic);
      course_.peak = std::max(course_.peak, axial_);
      if (state_.ledger.breakages == 0) course_.intact = course_.peak;
      course_.reading = std::max(course_.reading, test_stress(scene_, state_, now_));
      if (course_.overfull < 0 && scene_.model.has_balls() && now_.volume > 0 &&
          dem::whole_solid(scene_.model, state_) > now_.volume)
        course_.overfull = std::max(0.0, axial_);
      course_.errors.add(state_, now_);
      course_.row = row;
      show();
      history_.save(2);
      if (scene_.test.final_stress && axial_ >= *scene_.test.final_stress) return false;
    }
    if (due()) {
      const Stop stop = stop_of(over_);
      save_checkpoint();
      if (stop == Stop::asked) status_ = interrupted, ending_ = "interrupted; --resume goes on from checkpoint.h5";
      if (stop == Stop::time) status_ = out_of_time, ending_ = "out of time; --resume goes on from checkpoint.h5";
      if (stop != Stop::none) return false;
    }
    if (there) return true;
  }
}

void RveRun::march() {
  const auto rows =
      static_cast<std::uint64_t>(std::ceil(scene_.test.duration / scene_.output.history_interval * (1 - 1e-9)));
  dem::check_sanity(scene_.model, state_);
  if (!options_.resume) write_row();
  axial_ = axial_stress(scene_, state_, now_);
  error_ = dem::energy_error(state_.ledger, now_.kinetic + now_.elastic);
  for (std::uint64_t row = course_.row + 1; row <= rows; ++row) {
    const double time = static_cast<double>(row) * scene_.output.history_interval;
    if (!go_to_row(row, row == rows ? scene_.test.duration : time)) return;
  }
}

/// The scene's, and what the run has shown.
std::vector<std::string> RveRun::notes() const {
  std::vector<std::string> all = scene_.notes;
  if (course_.overfull >= 0)
    all.push_back(
        fmt::format("from {:.4g} MPa on the fines no longer fit into the voids (void_ratio_all is below 0): the "
                    "sample is softer than with them; see lost_mass",
                    course_.overfull / 1e6));
  return all;
}

nlohmann::json RveRun::summary() const {
  nlohmann::json summary = provenance();
  summary["title"] = scene_.title;
  if (const auto all = notes(); !all.empty()) summary["notes"] = all;
  summary["scene_file"] = std::filesystem::path(scene_.file).filename().string();
  summary["scene"] = scene_.record;
  summary["status"] = status_;
  summary["ending"] = ending_;
  summary["seed"] = scene_.model.seed;
  summary["threads"] = options_.threads;
  summary["counts"] = {{"grains_start", scene_.state.grains.size()},
                       {"grains", state_.grains.size()},
                       {"breakages", state_.ledger.breakages},
                       {"bonds_broken", state_.ledger.bonds_broken},
                       {"steps", state_.steps},
                       {"grain_steps", course_.grain_steps},
                       {"history_rows", history_.rows()}};
  if (const double bulk = dem::bulk_volume(scene_.state.boundary); bulk > 0)
    summary["sample"] = {{"bulk_density_kg_m3", dem::total_mass(scene_.state.grains) / bulk},
                         {"solid_fraction", dem::solid_volume(scene_.state.grains) / bulk}};
  summary["mass"] = {{"start_kg", dem::total_mass(scene_.state.grains)},
                     {"grains_kg", dem::total_mass(state_.grains)},
                     {"lost_kg", state_.ledger.fines.mass}};
  if (scene_.of_hulls()) {
    const dem::Roundness round = dem::roundness(state_.grains);
    summary["shape"] = {{"sphericity", round.sphericity}, {"angularity", round.angularity}};
  }
  if (scene_.cells) {
    const dem::BondedFaces& f = scene_.cells->faces;
    summary["cells"] = {{"cells", scene_.state.grains.size()},
                        {"bonds_start", f.bonds},
                        {"unbonded_faces", f.unbonded},
                        {"too_coarse_for_energy", f.coarse},
                        {"fragments", dem::fragments_of(state_).size}};
  }
  if (scene_.model.breakable()) {
    const dem::Fines& f = state_.ledger.fines;
    auto vector = [](const dem::Vec3& v) { return nlohmann::json{v.x(), v.y(), v.z()}; };
    summary["fines"] = {{"mass_kg", f.mass},
                        {"kinetic_J", f.kinetic},
                        {"momentum_kg_m_s", vector(f.momentum)},
                        {"angular_momentum_kg_m2_s", vector(f.angular_momentum)}};
  }
  summary["energy"] = ledger_json(state_, now_);
  summary["errors"] = course_.errors.json(state_);
  const auto device = [&](const char* name, double joule) {
    if (joule != 0) summary["errors"][name] = joule / dem::energy_scale(state_.ledger, now_.kinetic + now_.elastic);
  };
  device("local_damping", state_.ledger.local_damping), device("scaled_inertia", state_.ledger.inertia);
  summary["errors"]["packing_overlap"] = scene_.packing_overlap;
  summary["results"] = {
      {"peak_axial_stress_Pa", course_.peak}, {"final_time_s", state_.time}, {"final_void_ratio", now_.void_ratio}};
  if (tells_stress(scene_)) summary["results"]["peak_stress_Pa"] = course_.reading;
  if (scene_.output.bursts > 0) summary["bursts"] = bursts_json(scene_, state_);
  if (scene_.model.breakable()) summary["results"]["peak_before_breakage_Pa"] = course_.intact;
  summary["seconds"] = {
      {"preparation_wall", ready_}, {"loading_wall", earlier_ + end_ - ready_}, {"cpu", cpu_seconds()}};
  return summary;
}

void RveRun::finish() {
  end_ = clock_.wall();
  try {
    history_.save();
    if (status_ == finished || status_ == unstable) frames_.write_last(state_), gradings_.write_last(state_);
    const std::filesystem::path folder(options_.directory);
    if (scene_.output.bursts > 0) dem::write_whole((folder / "bursts.csv").string(), bursts_text(scene_, state_));
    dem::write_whole((folder / "summary.json").string(), summary().dump(2) + "\n");
  } catch (const std::exception&) {  // of one fault one line
    if (status_ != failed) throw;
  }
  const char* how = status_ == interrupted ? "interrupted" : status_ == out_of_time ? "out of time" : "stopped";
  progress_.finish(fmt::format(
      "{}: t {:.5g} s, peak stress {:.4g} MPa, {} -> {} grains, {} breakages, mass lost {:.2f} %, worst "
      "energy error {:.2f} %, "
      "{} steps in {} ({})",
      status_ == finished ? "finished" : how, state_.time, course_.peak / 1e6, scene_.state.grains.size(),
      state_.grains.size(), state_.ledger.breakages,
      100 * state_.ledger.fines.mass / dem::total_mass(scene_.state.grains), 100 * course_.errors.energy.worst,
      state_.steps, duration_text(earlier_ + end_ - ready_), options_.directory));
  if (const auto all = notes(); all.size() > scene_.notes.size()) progress_.note("  note: " + all.back());
  if (status_ == unstable || status_ == failed) say_fault(options_, fmt::format("{}: {}", options_.scene, ending_));
}

int RveRun::go() {
  try {
    march();
  } catch (const dem::Unstable& e) {
    status_ = unstable, ending_ = e.what();
  } catch (const std::exception& e) {  // of the system: what there is may still be kept
    status_ = failed, ending_ = e.what();
  }
  finish();
  return status_;
}

}  // namespace grus::app
