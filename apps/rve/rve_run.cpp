// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/rve_run.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "apps/run/folder.hpp"
#include "apps/rve/bursts.hpp"
#include "apps/rve/going_on.hpp"
#include "dem/io/archive.hpp"
#include "dem/io/whole_file.hpp"
#include "dem/rve/check_state.hpp"
#include "dem/rve/crushing.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/step.hpp"
#include "dem/sample/gauge.hpp"

namespace grus::app {
namespace {

std::string checkpoint_of(const Options& options) { return options.directory + "/checkpoint.h5"; }

/// The stress that the test itself tells, where there is one.
const char* stress_name(const dem::Programme& test) {
  if (!dem::tells_stress(test)) return "stress";
  return dem::tells_q(test) ? "q" : "nominal stress";
}

double in_mpa(double stress) { return stress / 1e6 + 0.0; }  // 0 rather than -0

/// To a hundredth, and then 0 rather than -0.
double in_percent(double share) { return std::round(1e4 * share) / 100 + 0.0; }

}  // namespace

RveRun::RveRun(const Options& options, RveScene& scene, dem::Sample sample, dem::Team& team, Begun begun,
               const dem::Checkpoint& kept, const Clock& clock, double ready)
    : options_(options),
      scene_(scene),
      own_(scene.model),
      sample_(std::move(sample)),
      team_(team),
      clock_(clock),
      ready_(ready),
      state_(std::move(begun.state)),
      prepared_(std::move(begun.prepared)),
      columns_(rve_columns({scene, sample_})),
      history_(result_file(options.directory, "history.csv"), names_of(columns_)),
      frames_(options, scene.output, scene.test.duration),
      cracks_(options, scene.output),
      gradings_(options.directory, scene, sample_.state),
      first_grains_(take_first(scene, sample_)),
      progress_(options),
      limit_(options.started, options.max_time) {
  course_.initial_cell = state_.boundary.cell.began(), course_.initial_size = scene.test.loading.initial_size;
  course_.bulk = dem::bulk_volume(state_.boundary), course_.solid = dem::solid_volume(state_.grains);
  course_.mass = dem::total_mass(state_.grains);
  if (options.resume) take_up(kept);
  now_ = dem::survey(scene.model, state_, team_, room_), ledger_ = state_.ledger;
  saved_ = clock.wall(), earlier_ = course_.wall, earlier_cpu_ = course_.cpu;
  scene.model.before_breaks = [this](const dem::State& state, std::span<const dem::Break> breaks) {
    hear_of_breaks(state, breaks);
  };
}

void RveRun::take_up(const dem::Checkpoint& kept) {
  const std::string path = checkpoint_of(options_) + ": ";
  const nlohmann::json about = nlohmann::json::parse(kept.about);
  try {
    state_ = dem::state_of(kept.parts[0]);
    dem::check_state(scene_.model, state_);
    dem::Loader loader(kept.parts[1]);
    dem::walk(loader, course_);
    if (staged()) dem::walk(loader, scene_.test.now), stages_ = about.at("stages");
    ended_ = about.value("ended", false);
    double& every = scene_.output.history_interval;
    if (scene_.output.place_of_history.empty()) every = about.value("history_interval", every);
    history_.restore(with_columns(kept.parts[2], history_.columns()), about.at("rows"));
    gradings_.restore(kept.parts[3], about.at("gradings"));
    frames_.restore(about.at("frames").get<GrainFrames::Series>());
    cracks_.restore(about.value("lattices", GrainFrames::Series{}));
    prepared_ = about.at("prepared");
    scene_.notes = about.at("notes").get<std::vector<std::string>>();
    check_course(loader.at_end());
  } catch (const InputError& e) {
    throw InputError(path + e.what());
  } catch (const nlohmann::json::exception&) {
    throw InputError(path + "checkpoint is damaged: what it tells of itself");
  }
  scene_.test.loading.initial_size = course_.initial_size;
  if (staged() && scene_.test.now.begun) dem::set_stage(own_, scene_.model, scene_.test);
  say(options_,
      fmt::format("{}\n  going on from t = {:.4g} s, {} grains", scene_.title, state_.time, state_.grains.size()));
}

/// The course, its rows and the state belong together.
void RveRun::check_course(bool whole) const {
  const double row = static_cast<double>(course_.row), every = scene_.output.history_interval, slack = 1e-6 * every;
  const auto& c = course_;
  const bool finite = c.initial_cell.allFinite() && c.initial_size.allFinite() && std::isfinite(c.peak + c.intact) &&
                      std::isfinite(c.reading + c.overfull) && c.wall >= 0 && std::isfinite(c.wall) && c.cpu >= 0 &&
                      std::isfinite(c.cpu);
  const auto lines = static_cast<std::size_t>(std::count(history_.text().begin(), history_.text().end(), '\n'));
  const bool rows = history_.rows() == course_.row + 1 && lines == history_.rows() + 1;
  if (whole && finite && rows && staged()) {
    const dem::StageNow& now = scene_.test.now;
    const std::size_t stages = scene_.test.stages.size();
    const bool there =
        now.stage < stages ? now.leg < scene_.test.stages[now.stage].legs() : now.stage == stages && !now.begun;
    if (there && now.row_time <= state_.time && now.first_row <= course_.row) return;
  }
  if (!whole || !finite || !rows || staged() ||
      !(ended_ || state_.time >= row * every - slack || state_.time >= scene_.test.duration - slack) ||
      !(state_.time <= (row + 1) * every + slack && state_.time <= scene_.test.duration + slack))
    throw InputError("checkpoint is damaged: rows and time do not match");
}

void RveRun::save_checkpoint() {
  const Clock writing;
  cracks_.write_kept();
  dem::Saver saver;
  course_.cpu = earlier_cpu_ + cpu_seconds();
  dem::walk(saver, course_);
  if (staged()) dem::walk(saver, scene_.test.now);
  nlohmann::json about{{"program", "grus-rve"},          {"scene", *scene_.record}, {"prepared", prepared_},
                       {"notes", scene_.notes},          {"rows", history_.rows()}, {"frames", frames_.series()},
                       {"gradings", gradings_.written()}};
  about["history_interval"] = scene_.output.history_interval, about["ended"] = ended_;
  if (!cracks_.series().empty()) about["lattices"] = cracks_.series();
  if (staged()) about["stages"] = stages_, about["stages_begun"] = scene_.test.now.stage + scene_.test.now.begun;
  dem::write_checkpoint(result_file(options_.directory, "checkpoint.h5"), about.dump(), [&](const dem::TakePart& take) {
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

/// The part of the test that is done. Where a stress ends it: by the time of the ramp, or from the last rows; a stress
/// that grows faster and faster is reached before a straight line through the origin says so.
double RveRun::done() const {
  if (staged()) return dem::stages_done(scene_.test, state_);
  const double part = state_.time / scene_.test.duration;
  if (!scene_.test.final_stress || course_.row == 0) return part;
  const double asked = *scene_.test.final_stress;
  if (scene_.test.stress_time) return std::max(part, std::min(state_.time / *scene_.test.stress_time, 1.0));
  const double left = asked - course_.axial, rise = course_.axial - course_.before;
  const double rows = static_cast<double>(course_.row);
  const double straight = std::clamp(course_.axial / asked, 0.0, 1.0);
  return std::max({part, straight, rise > 0 && left > 0 ? rows / (rows + left / rise) : 0.0});
}

/// Grains and bonds, of which there are.
std::string RveRun::broken(const char* between) const {
  const bool bonded = sample_.bonded() || state_.ledger.bonds_broken > 0;
  std::string bonds = fmt::format("{} bonds", state_.ledger.bonds_broken);
  if (bonded && state_.ledger.breakages == 0) return bonds;
  return fmt::format("{} grains", state_.ledger.breakages) + (bonded ? between + bonds : "");
}

/// What loads the grains now, as far as there is something to tell: "  stress 1.2 MPa", "  load 250 N".
std::string RveRun::load_text() const {
  if (dem::has_stress(scene_.test, state_)) return fmt::format("  stress {:.3g} MPa", in_mpa(shown_));
  if (const auto load = dem::dead_load(scene_.test, state_)) return fmt::format("  load {:.4g} N", *load);
  return "";
}

/// The same of the whole test.
std::string RveRun::peak_text() const {
  if (const auto load = dem::dead_load(scene_.test, state_); load && !dem::has_stress(scene_.test, state_))
    return fmt::format(", load {:.4g} N", *load);
  if (!dem::has_stress(scene_.test, state_)) return "";
  const bool own = dem::tells_stress(scene_.test);
  return fmt::format(", peak {} {:.4g} MPa{}", stress_name(scene_.test), in_mpa(own ? course_.reading : course_.peak),
                     state_.ledger.breakages > 0 && !own
                         ? fmt::format(" ({:.4g} before the first breakage)", in_mpa(course_.intact))
                         : "");
}

/// Shows a moment between rows: stress and error are the last row's.
void RveRun::show() {
  course_.wall = earlier_ + clock_.wall() - ready_;
  progress_.show(
      done(),
      fmt::format(
          "t {:.4g} s  strain {:.4f}{}  grains {}  broken {}  energy error "
          "{:.2f} %  {:.3g} steps/s",
          state_.time,
          std::round(1e4 * dem::axial_strain(scene_.test, sample_.state, state_, course_.initial_cell)) / 1e4 + 0.0,
          load_text(), state_.grains.size(), broken(", "), in_percent(error_),
          static_cast<double>(state_.steps) / course_.wall));
}

double RveRun::strain_of_gradings() const {
  return staged() ? dem::axial_strain(scene_.test, sample_.state, state_, course_.initial_cell)
                  : state_.time * scene_.test.strain_rate;
}

void RveRun::write_row() {
  history_.add(values_of(columns_, Row(scene_, sample_, first_grains_, state_, now_, course_.initial_cell)));
  const double at = staged() ? done() * scene_.test.duration : state_.time;
  frames_.write_if_due(state_, at);
  cracks_.write_kept();
  gradings_.write_if_due(state_, at, strain_of_gradings());
}

/// How to meet the stress that ends the test, once it is near: from a half of it on, or where it grows that fast.
dem::Landing RveRun::landing() const {
  if (!scene_.test.final_stress) return {};
  const double asked = *scene_.test.final_stress;
  if (course_.axial < 0.5 * asked && course_.axial + 4 * (course_.axial - course_.before) < asked) return {};
  return dem::stress_landing(scene_.test, sample_.state);
}

/// What is shown until the next row.
void RveRun::read_off() {
  axial_ = dem::axial_stress(scene_.test, sample_.state, state_, now_);
  shown_ = dem::tells_stress(scene_.test) ? dem::test_stress(scene_.test, state_, now_) : axial_;
  ledger_ = state_.ledger, error_ = dem::told_energy_error(state_, now_.kinetic + now_.elastic);
}

/// What is told in the end is of one moment: where the run was stopped, and not of its last row.
void RveRun::read_off_stop() {
  now_ = dem::survey(scene_.model, state_, team_, room_);
  read_off();
  course_.axial = axial_, note_peak();
}

void RveRun::note_peak() {
  course_.peak_is_last = axial_ >= course_.peak, course_.peak = std::max(course_.peak, axial_);
}

/// Until the row is written; false: the run ends here.
bool RveRun::go_to_row(std::uint64_t row, double until, const dem::Landing& landing) {
  while (true) {
    const bool there = dem::load(
        scene_.model, state_, scene_.test.loading, until, team_, [&](double) { return show(), !due(); }, landing);
    if (there) {
      const dem::Survey found = dem::survey(scene_.model, state_, team_, room_);
      dem::check_sanity(scene_.model, state_, found.kinetic + found.elastic, found.deepest);
      now_ = found;
      if (staged()) dem::count_row(scene_.test, state_);
      write_row();
      read_off();
      course_.before = course_.axial, course_.axial = axial_, note_peak();
      const double reading = dem::test_stress(scene_.test, state_, now_);
      course_.reading_is_last = reading >= course_.reading, course_.reading = std::max(course_.reading, reading);
      if (course_.overfull < 0 && scene_.model.has_balls() && now_.volume > 0 &&
          dem::whole_solid(scene_.model, state_) > now_.volume)
        course_.overfull = std::max(0.0, axial_);
      course_.errors.add(state_, staged() && !scene_.test.loading.holds ? dem::Loading{} : scene_.test.loading, now_);
      course_.errors.before_peak.add(state_.ledger, dem::tells_stress(scene_.test) ? reading : axial_, now_.kinetic,
                                     now_.kinetic + now_.elastic);
      course_.step.add(scene_.model, state_, scene_.test.strain_rate, dem::mean_pressure(now_.stress));
      course_.row = row;
      show();
      history_.save(2);
      if (scene_.test.final_stress && (axial_ >= *scene_.test.final_stress || state_.time < until)) return false;
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

/// Grains give way between rows, where the stress is largest.
void RveRun::hear_of_breaks(const dem::State& state, std::span<const dem::Break> breaks) {
  cracks_.keep(state, breaks);
  const dem::Programme& test = scene_.test;
  const bool pressed = dem::has_faces(test, state) || dem::bulk_volume(state.boundary) > 0;
  const double axial = pressed ? dem::axial_stress(test, sample_.state, state) : 0;
  const double reading = test.gauge ? dem::test_stress(test, state, {}) : 0;
  if (axial > course_.peak) course_.peak = axial, course_.peak_is_last = false;
  if (reading > course_.reading) course_.reading = reading, course_.reading_is_last = false;
  if (state.ledger.breakages == 0) course_.intact = course_.peak > 0 ? course_.peak : course_.reading;
}

void RveRun::write_first_row() {
  write_row();
  course_.axial = course_.before = dem::axial_stress(scene_.test, sample_.state, state_, now_);
  course_.step.add(scene_.model, state_, scene_.test.strain_rate, dem::mean_pressure(now_.stress));
}

void RveRun::march() {
  const auto rows =
      static_cast<std::uint64_t>(std::ceil(scene_.test.duration / scene_.output.history_interval * (1 - 1e-9)));
  dem::check_sanity(scene_.model, state_);
  if (!options_.resume) write_first_row();
  read_off();
  const bool ended = std::exchange(ended_, false);
  if (scene_.test.final_stress && ended && course_.axial >= *scene_.test.final_stress) return;
  for (std::uint64_t row = course_.row + 1; row <= rows; ++row) {
    const double time = static_cast<double>(row) * scene_.output.history_interval;
    if (!go_to_row(row, row == rows ? scene_.test.duration : time, landing())) return;
  }
}

/// What is told is good until then: of a run that became unstable until its last row.
double RveRun::good_until() const {
  if (staged() && status_ == unstable) return scene_.test.now.row_time;
  return status_ == unstable ? static_cast<double>(course_.row) * scene_.output.history_interval : state_.time;
}

void RveRun::finish() {
  end_ = clock_.wall();
  try {
    history_.save();
    cracks_.write_kept();
    if (status_ == interrupted || status_ == out_of_time) read_off_stop();
    ended_ = status_ == finished;
    if (ended_ && scene_.output.last_state) save_checkpoint();
    if (status_ == finished || status_ == unstable)
      frames_.write_last(state_), gradings_.write_last(state_, strain_of_gradings());
    if (scene_.output.bursts > 0)
      dem::write_whole(result_file(options_.directory, "bursts.csv"), bursts_text(scene_, state_, good_until()));
    if (scene_.output.broken_bonds)
      dem::write_whole(result_file(options_.directory, "broken_bonds.csv"), broken_bonds_text(state_, good_until()));
    const std::string last = result_file(options_.directory, "summary.json");
    nlohmann::json told = summary();
    told["files"] = result_files(options_.directory);
    dem::write_whole(last, told.dump(2) + "\n");
  } catch (const std::exception&) {  // of one fault one line
    if (status_ != failed) throw;
  }
  const char* how = status_ == interrupted ? "interrupted" : status_ == out_of_time ? "out of time" : "stopped";
  progress_.finish(fmt::format(
      "{}: t {:.5g} s{}, {} -> {} grains, {} broken, mass lost {:.2f} %, worst energy error {:.2f} %, {} steps in {} "
      "({})",
      status_ == finished ? "finished" : how, state_.time, peak_text(), first_grains_.count, state_.grains.size(),
      broken(" and "), in_percent(state_.ledger.fines.mass / first_grains_.mass), 100 * course_.errors.energy.worst,
      state_.steps, duration_text(earlier_ + end_ - ready_), options_.directory));
  const auto all = notes();
  for (std::size_t k = scene_.notes.size(); k < all.size(); ++k) progress_.note("  note: " + all[k]);
  if (status_ == unstable || status_ == failed) say_fault(options_, fmt::format("{}: {}", options_.scene, ending_));
}

int RveRun::go() {
  try {
    staged() ? march_stages() : march();
  } catch (const dem::Unstable& e) {
    status_ = unstable, ending_ = e.what();
  } catch (const std::exception& e) {  // of the system: what there is may still be kept
    status_ = failed, ending_ = e.what();
  }
  finish();
  return status_;
}

}  // namespace grus::app
