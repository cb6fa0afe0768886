// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/rehearsal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/run/command.hpp"
#include "apps/scene/stage_scene.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"
#include "dem/sample/gauge.hpp"
#include "dem/sample/stages.hpp"

namespace grus::app {
namespace {

constexpr double most_larger = 30;  // beyond, the grains' inertia would make another test of it
constexpr double growth = 4;        // of the cost that the start tells, for which room is left
constexpr int tried = 20;           // steps
constexpr double tries = 12;        // of the cost of a step, in a rehearsal
constexpr double share = 0.7;       // of the time that is left, for a second one
constexpr double doubt_of_masses = 2, doubt_of_the_rest = 3;  // factors, as tried on the shipped scenes

void scale_masses(dem::State& state, double factor) {
  dem::Grains& g = state.grains;
  for (auto* masses : {&g.mass, &g.solid_mass, &g.turn_mass})
    for (double& m : *masses) m *= factor;
  for (auto& m : g.motion) m.inverse_mass /= factor, m.inverse_inertia /= factor;
  for (auto& i : g.inertia) i.moments *= factor;
  for (auto& l : g.angular_momentum) l *= factor;
}

/// All times of the numerics `larger`, all weights as they were.
dem::Model heavier(dem::Model model, double larger) {
  for (auto& m : model.materials) m.density *= larger * larger;
  for (double* step : {&model.numerics.time_step, &model.numerics.max_time_step, &model.numerics.inertia_step})
    *step *= larger;
  model.motion.gravity /= larger * larger;
  model.numerics.max_energy_error = INFINITY;
  return model;
}

class Trial {
public:
  Trial(const RveScene& scene, const dem::State& begin, double budget, dem::Team& team, const dem::StageWatch& watch)
      : plain_(scene.model),
        test_(scene.test),
        first_(begin),
        state_(begin),
        budget_(budget),
        team_(team),
        watch_(watch),
        rows_(std::max(1.0, std::ceil(scene.test.duration / scene.output.history_interval * (1 - 1e-9)))) {
    probe();
  }

  /// As far above 1 as the budget asks. Implicit steps are chosen by how fast grains approach, and free motion by its
  /// speeds: both are tried as they are.
  double larger() const {
    if (plain_.stepper != &dem::explicit_stepper || test_.kind == dem::TestKind::free) return 1;
    if (!test_.stages.empty() && !known_duration(test_)) return most_larger;
    return std::clamp(growth * cost_ * test_.stress_time.value_or(test_.duration) / step_ / budget_, 1.0, most_larger);
  }

  Rehearsal go(double larger) {
    found_.larger = larger;
    own_ = model_ = heavier(plain_, larger);
    for (auto& s : test_.stages)
      if (s.gravity) *s.gravity /= larger * larger;
    scale_masses(state_, larger * larger);
    if (model_.numerics.time_step == 0) state_.next_estimate = state_.steps;
    try {
      test_.stages.empty() ? march() : march_stages();
    } catch (const dem::Unstable&) {  // so much of it is known
    }
    extrapolate();
    return found_;
  }

  double spent() const { return clock_.wall(); }

private:
  /// What a step costs now (s), with the grains' own masses.
  void probe() {
    dem::State own = state_;
    scale_masses(own, 1 / (found_.larger * found_.larger));
    if (plain_.numerics.time_step == 0) own.next_estimate = own.steps;
    dem::update_time_step(plain_, own, team_);
    const Clock timer;
    const std::uint64_t end = own.steps + tried;
    while (own.steps < end) {
      dem::update_time_step(plain_, own, team_);
      dem::run_steps(plain_, own, 2, team_);
    }
    cost_ = timer.wall() / tried, step_ = own.dt, probed_ = clock_.wall();
  }

  double done() const {
    return test_.stages.empty() ? state_.time / test_.stress_time.value_or(test_.duration)
                                : dem::stages_done(test_, state_);
  }

  /// To the next row or to where the budget ends; false: it has.
  bool go_to(double until, const dem::Landing& landing) {
    const std::uint64_t before = state_.steps;
    const Clock timer;
    const bool there = dem::load(
        model_, state_, test_.loading, until, team_,
        [&](double) {
          dem::tell(watch_of(), std::min(1.0, std::max(done(), clock_.wall() / budget_)), "the test was rehearsed");
          return clock_.wall() < budget_;
        },
        landing);
    dem::survey(model_, state_, team_, room_);
    const double steps = static_cast<double>(state_.steps - before), wall = timer.wall();
    found_.steps += steps * found_.larger;
    found_.seconds += found_.larger > 1 ? steps * found_.larger * cost_ + std::max(0.0, wall - steps * cost_) : wall;
    course_.push_back({done(), found_.steps, found_.seconds});
    if (there && found_.larger > 1 && clock_.wall() - probed_ > budget_ / tries) probe();
    return there && clock_.wall() < budget_;
  }
  dem::Watch watch_of() const {
    return [this](double part) { return !watch_ || watch_(part, "rehearsal"); };
  }

  void march() {
    const dem::Landing landing = test_.final_stress ? dem::stress_landing(test_, first_) : dem::Landing{};
    for (double row = 1; row <= rows_; ++row) {
      const double until = row == rows_ ? test_.duration : test_.duration * row / rows_;
      if (!go_to(until, landing)) return;
      if (test_.final_stress && (state_.time < until || landing.left(state_) <= 0)) break;
    }
    whole_ = true;
  }

  void march_stages() {
    dem::StageNow& now = test_.now;
    std::uint64_t row = 0;
    while (now.stage < test_.stages.size()) {
      if (!now.begun) dem::begin_stage(own_, model_, state_, row, test_);
      if (!now.leg_begun) dem::begin_leg(own_, model_, state_, test_);
      const dem::EndedBy end = dem::leg_ended(test_, state_);
      if (end == dem::EndedBy::limit) return;
      if (end != dem::EndedBy::nothing) {
        dem::end_leg(test_, end);
        continue;
      }
      if (!go_to(dem::row_until(test_), dem::leg_landing(test_))) return;
      dem::count_row(test_, state_), ++row;
    }
    whole_ = true;
  }

  /// The rest as the last quarter of what there is.
  void extrapolate() {
    found_.part = whole_ ? 1 : course_.empty() ? 0 : course_.back().done;
    if (whole_ || !(found_.part > 0)) return;
    const auto from =
        std::find_if(course_.begin(), course_.end(), [&](const Point& p) { return p.done >= 0.75 * found_.part; });
    const Point start = from == course_.begin() ? Point{} : *std::prev(from), end = course_.back();
    const double left = std::max(0.0, 1 - end.done) / (end.done - start.done);
    found_.steps += left * (end.steps - start.steps), found_.seconds += left * (end.seconds - start.seconds);
  }

  struct Point {
    double done = 0, steps = 0, seconds = 0;
  };
  const dem::Model& plain_;
  dem::Model own_, model_;
  dem::Programme test_;
  const dem::State& first_;
  dem::State state_;
  dem::SurveyRoom room_;
  double budget_;
  dem::Team& team_;
  const dem::StageWatch& watch_;
  double rows_;
  Clock clock_;
  double cost_ = 0, step_ = 0, probed_ = 0;
  Rehearsal found_;
  std::vector<Point> course_;
  bool whole_ = false;
};

}  // namespace

Rehearsal rehearse(const RveScene& scene, const dem::State& begin, double budget, dem::Team& team,
                   const dem::StageWatch& watch) {
  Trial trial(scene, begin, budget, team, watch);
  const double larger = trial.larger();
  const Rehearsal found = trial.go(larger);
  const double spent = trial.spent(), left = share * (budget - spent), next = std::max(1.0, larger * spent / left);
  if (found.part < 1 || !(left > spent) || next > share * larger) return found;
  return Trial(scene, begin, budget - spent, team, watch).go(next);
}

namespace {

double doubt(const Rehearsal& found, double scale = 1) {
  if (found.larger <= 1 && found.part >= 1 && scale == 1) return 1;
  return found.part < 0.5 ? doubt_of_the_rest : doubt_of_masses;
}

}  // namespace

std::string time_text(const Rehearsal& found, double scale) {
  if (!(found.part > 0)) return "not known";
  const double seconds = found.seconds * scale, factor = doubt(found, scale);
  if (factor == 1) return "about " + duration_text(seconds);
  return fmt::format("{} to {}", duration_text(seconds / factor), duration_text(seconds * factor));
}

std::string steps_text(const Rehearsal& found) {
  if (!(found.part > 0)) return "not known";
  const double factor = doubt(found);
  if (factor == 1) return fmt::format("about {:.3g}", found.steps);
  return fmt::format("{:.2g} to {:.2g}", found.steps / factor, found.steps * factor);
}

std::string basis_text(const Rehearsal& found) {
  const std::string part = found.part >= 1 ? "the whole test" : fmt::format("{:.2g} % of the test", 100 * found.part);
  if (found.larger <= 1) return part + " was gone through";
  return fmt::format("{} was rehearsed with grains {:.3g} times as heavy", part, found.larger * found.larger);
}

}  // namespace grus::app
