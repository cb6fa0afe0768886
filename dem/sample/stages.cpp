// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/stages.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/contact/forces.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"

namespace grus::dem {
namespace {

/// All axes alike have their stress once each is within this share of it.
constexpr double stress_tolerance = 1e-3;

const Stage& stage_of(const Programme& test) { return test.stages[test.now.stage]; }

/// Of the leg: 1 compresses, -1 unloads. Cycles begin with compression.
double sense(const Stage& stage, const StageNow& now) {
  if (stage.kind == StageKind::unload) return -1;
  if (stage.kind == StageKind::cyclic) return now.leg % 2 == 0 ? 1 : -1;
  return stage.strain_rate < 0 ? -1 : 1;
}

/// Where a leg of a cycle turns back, as a way from where the stage began; the last leg goes back to there.
double turn_of(const Stage& stage, const StageNow& now) {
  return now.leg + 1 == stage.legs() ? 0 : sense(stage, now) * stage.amplitude;
}

/// The stress (Pa) that ends the stage.
std::optional<double> end_stress(const Stage& stage, const StageNow& now) {
  return stage.to_turn ? std::optional(now.turned) : stage.until.stress;
}

/// The stress or deviator (Pa) that ends the leg; none: no stress does.
std::optional<double> goal_of(const Stage& stage, const StageNow& now) {
  if (stage.kind == StageKind::cyclic && stage.swing != Swing::strain) return now.leg_from + turn_of(stage, now);
  if (stage.kind == StageKind::cyclic || stage.all) return {};
  const auto stress = end_stress(stage, now);
  return stress ? stress : stage.until.deviator;
}

/// The stress (Pa) whose levels rows are at: the goal, or what all axes are brought to.
std::optional<double> levels_to(const Stage& stage, const StageNow& now) {
  return stage.all ? stage.until.stress : goal_of(stage, now);
}

/// The reading that goes to the goal; of all axes their mean.
double towards_goal(const Programme& test, const State& s) {
  const Stage& stage = stage_of(test);
  if (stage.all) return -normal_stresses(s).mean();
  if (stage.kind == StageKind::cyclic) return stage_swing(test, s);
  if (end_stress(stage, test.now)) return stage_stress(test, s);
  const Vec3 stress = -normal_stresses(s);
  return 1.5 * (stress[stage.axis] - stress.mean());  // of the axis, less the mean of the others
}

/// Worst share by which the axes are off what they all seek.
double off(const Stage& stage, const State& s) {
  return (-normal_stresses(s).array() / *stage.until.stress - 1).abs().maxCoeff();
}

/// The volume goes with the axes, one way: it is known from the start which void ratios are behind.
bool volume_follows(const Stage& stage) {
  return (stage.one_way() || stage.kind == StageKind::shear) && !stage.plane && stage.lateral == Lateral::fixed;
}

bool too_far(const Stage& stage, double gone) { return stage.max_strain > 0 && gone >= stage.max_strain * (1 - 1e-9); }

/// Time at which the axis has gone a way, where its rate is kept (s).
double time_of(const Stage& stage, double began, double way) { return began + way / std::abs(stage.strain_rate); }

void set_grains(const Model& own, Model& model, const Programme& test) {
  const Stage& stage = stage_of(test);
  for (std::size_t m = 0; m < model.materials.size(); ++m) {
    const bool grains = std::isfinite(own.materials[m].youngs_modulus);
    model.materials[m].friction =
        grains ? stage.friction.value_or(own.materials[m].friction) : own.materials[m].friction;
    model.materials[m].damping = own.materials[m].fixed ? 0 : stage.damping.value_or(own.materials[m].damping);
  }
  renew_friction(model);
  model.motion.gravity = own.motion.gravity;
  for (std::size_t k = 0; k <= test.now.stage; ++k)
    if (test.stages[k].gravity) model.motion.gravity = *test.stages[k].gravity;
}

/// What the axis is told to do in this leg.
AxisControl drive_of(const Stage& stage, const StageNow& now) {
  const double way = sense(stage, now);
  if (!stage.stress_rate) return {.strain_rate = -way * std::abs(stage.strain_rate), .stress = {}};
  const double rate = -way * *stage.stress_rate;
  return {.strain_rate = 0,
          .stress = -now.stress[stage.axis] - rate * now.leg_began,
          .max_rate = std::abs(stage.strain_rate),
          .stress_rate = rate};
}

Loading loading_of(const Stage& stage, const StageNow& now, const Vec3& initial_size) {
  Loading loading;
  loading.initial_size = initial_size;
  if (stage.kind == StageKind::deposit || stage.kind == StageKind::relax) return loading;
  loading.driven = true;
  if (stage.plane) {
    const auto [along, across] = *stage.plane;
    loading.velocity_gradient = Mat3::Zero();
    (*loading.velocity_gradient)(along, across) = sense(stage, now) * std::abs(stage.strain_rate);
    return loading;
  }
  const double rate = std::abs(stage.strain_rate);
  const bool hold = stage.kind == StageKind::hold, held = stage.lateral == Lateral::held;
  for (int k = 0; k < 3; ++k) {
    AxisControl& axis = loading.axes[static_cast<std::size_t>(k)];
    if (stage.all)
      axis = {.strain_rate = 0, .stress = hold ? -now.stress[k] : -*stage.until.stress, .max_rate = rate};
    else if (k != stage.axis && held)
      axis = {.strain_rate = 0, .stress = -stage.lateral_stress.value_or(now.stress[k]), .max_rate = 2 * rate};
    else if (k == stage.axis)
      axis = hold ? AxisControl{.strain_rate = 0, .stress = -now.stress[k], .max_rate = rate} : drive_of(stage, now);
  }
  loading.holds = stage.holds();
  loading.isochoric = stage.lateral == Lateral::volume;
  return loading;
}

/// Springs that no limit holds any more give up what they hold, as friction: passes without friction look at none.
void release_springs(const Model& model, State& state) {
  if (grains_rub(model)) return;
  const double before = elastic_energy(model.law, state.contacts);
  drop_slide_springs(state.contacts);
  for (auto& column : state.contacts.contact.spring[roll_spring]) std::fill(column.begin(), column.end(), 0.0);
  state.ledger.friction += before - elastic_energy(model.law, state.contacts);
}

}  // namespace

const char* name_of(EndedBy end) {
  constexpr const char* names[] = {"",     "stress",           "deviator", "strain", "void_ratio",
                                   "time", "unbalanced_force", "cycles",   "limit"};
  return names[static_cast<std::size_t>(end)];
}

void set_stage(const Model& own, Model& model, Programme& test) {
  const Stage& stage = stage_of(test);
  set_grains(own, model, test);
  test.axis = stage.axis, test.strain_rate = sense(stage, test.now) * std::abs(stage.strain_rate);
  test.loading = loading_of(stage, test.now, test.loading.initial_size);
}

void begin_stage(const Model& own, Model& model, State& state, std::uint64_t row, Programme& test) {
  StageNow& now = test.now;
  const Stage& stage = stage_of(test);
  now.leg = 0, now.first_row = row, now.began = state.time, now.stress = -normal_stresses(state), now.begun = true,
  now.leg_begun = false;
  now.strain = stage_strain(test, state);
  now.void_ratio = void_ratio(state);
  if (stage.kind == StageKind::unload) now.turned = now.stress[stage.axis];
  const Vec3 pull = model.motion.gravity;
  set_stage(own, model, test);
  const bool pulled = model.motion.gravity != pull;  // long steps are as long as what falls allows
  if (pulled && model.stepper->long_steps && model.numerics.time_step == 0) state.next_estimate = state.steps;
  release_springs(model, state);
  stand(state);
}

void begin_leg(const Model& own, Model& model, State& state, Programme& test) {
  StageNow& now = test.now;
  now.leg_began = state.time, now.row = now.level = 0, now.leg_begun = true;
  set_stage(own, model, test);
  if (stage_of(test).kind == StageKind::cyclic) {
    if (now.leg == 0) now.leg_from = stage_swing(test, state);
  } else if (levels_to(stage_of(test), now)) {
    now.leg_from = towards_goal(test, state);
  }
  turn_loading(model, state, test.loading);
}

double stage_strain(const Programme& test, const State& s) {
  const Stage& stage = stage_of(test);
  if (stage.plane) return std::abs(stage.strain_rate) * (s.time - test.now.began);
  const double first = test.loading.initial_size[stage.axis];
  return first > 0 ? 1 - size_of(s.boundary)[stage.axis] / first : 0;
}

double stage_stress(const Programme& test, const State& s) {
  const Stage& stage = stage_of(test);
  if (!stage.plane) return -normal_stresses(s)[stage.axis];
  return love_weber(s, bulk_volume(s.boundary))((*stage.plane)[0], (*stage.plane)[1]);
}

double stage_swing(const Programme& test, const State& s) {
  const Stage& stage = stage_of(test);
  if (stage.swing == Swing::strain) return stage_strain(test, s);
  if (stage.swing == Swing::stress) return stage_stress(test, s);
  const Vec3 stress = -normal_stresses(s);
  return 1.5 * (stress[stage.axis] - stress.mean());
}

double unbalanced_force(const State& s) {
  double left = 0, force = 0;
  std::size_t fixed = 0;  // of rough walls
  for (std::size_t i = 0; i < s.grains.size(); ++i)
    if (s.grains.motion[i].inverse_mass == 0)
      ++fixed;
    else
      left += s.grains.force[i].norm();
  std::size_t links = s.bonds.face.row.size() + s.bonds.wall.size();
  for (std::size_t k = 0; k < s.contacts.size(); ++k)
    if (s.contacts.contact.touching(k)) force += s.contacts.touch[k].force.norm(), ++links;
  for (const FaceBond& bond : s.bonds.face.row) force += bond.force.norm();
  for (const FaceBond& bond : s.bonds.wall) force += bond.force.norm();
  if (!(force > 0)) return INFINITY;
  return left / static_cast<double>(s.grains.size() - fixed) / (force / static_cast<double>(links));
}

namespace {

/// Of a time, by which round-off may miss it (s), in a leg that ends at `end`. Steps may be far longer than the leg.
double slack_of(const StageNow& now, double end, const State& s) { return 1e-9 * std::min(s.dt, end - now.leg_began); }

}  // namespace

EndedBy leg_ended(const Programme& test, const State& s) {
  const Stage& stage = stage_of(test);
  const StageNow& now = test.now;
  const double end = leg_until(test), slack = slack_of(now, end, s), way = sense(stage, now);
  const StageEnds& until = stage.until;
  if (const auto goal = goal_of(stage, now); goal && way * (*goal - towards_goal(test, s)) <= 0)
    return stage.kind == StageKind::cyclic ? EndedBy::cycles
           : end_stress(stage, now)        ? EndedBy::stress
                                           : EndedBy::deviator;
  if (stage.all && until.stress && off(stage, s) <= stress_tolerance) return EndedBy::stress;
  const double gone = std::abs(stage_strain(test, s) - now.strain);
  if (until.strain) {
    const bool timed = stage.by_strain() && stage.kind != StageKind::cyclic;
    if (timed ? s.time >= time_of(stage, now.began, *until.strain) - slack : gone >= *until.strain)
      return EndedBy::strain;
  }
  if (until.void_ratio) {
    const double from = volume_follows(stage) ? way : now.void_ratio - *until.void_ratio;
    if ((void_ratio(s) - *until.void_ratio) * from <= 0) return EndedBy::void_ratio;
  }
  if (until.time && s.time >= now.began + *until.time - slack) return EndedBy::time;
  if (until.unbalanced_force && unbalanced_force(s) <= *until.unbalanced_force) return EndedBy::unbalanced_force;
  const bool late = s.time >= end - slack;
  if (late && stage.kind == StageKind::cyclic && stage.swing == Swing::strain) return EndedBy::cycles;
  return late || too_far(stage, gone) ? EndedBy::limit : EndedBy::nothing;
}

double leg_until(const Programme& test) {
  const Stage& stage = stage_of(test);
  const StageNow& now = test.now;
  double end = INFINITY;
  const auto by = [&](double time) { end = std::min(end, time); };
  if (stage.by_strain() && stage.kind == StageKind::cyclic) {
    const bool outer = now.leg == 0 || now.leg + 1 == stage.legs();
    by(time_of(stage, now.leg_began,
               stage.swing == Swing::strain ? (outer ? 1 : 2) * stage.amplitude : 2 * stage.max_strain));
  } else if (stage.by_strain()) {
    by(time_of(stage, now.began, stage.until.strain.value_or(stage.max_strain)));
  } else if (stage.strain_rate != 0) {  // a bound: a stress is sought
    const auto goal = goal_of(stage, now);
    const double ramp = stage.stress_rate && goal ? 1.1 * std::abs(*goal - now.leg_from) / *stage.stress_rate : 0;
    by(std::max(time_of(stage, now.began, stage.max_strain), now.began + ramp));
  }
  if (stage.until.time) by(now.began + *stage.until.time);
  if (stage.max_time > 0) by(now.began + stage.max_time);
  return end;
}

double row_until(const Programme& test) {
  const Stage& stage = stage_of(test);
  const StageNow& now = test.now;
  const double end = leg_until(test), rows = static_cast<double>(stage.rows);
  double span = end - now.leg_began;
  if (stage.by_strain() && stage.until.void_ratio && stage.lateral == Lateral::fixed && !stage.plane)
    span = std::min(
        span, std::abs(now.void_ratio - *stage.until.void_ratio) / (1 + now.void_ratio) / std::abs(stage.strain_rate));
  const double next = now.leg_began + static_cast<double>(now.row + 1) * span / rows;
  return next > end - 1e-9 * span ? end : next;
}

namespace {

/// How far a reading is from the stress at which the next row is due, of a leg that goes to a stress (Pa).
double left_to_level(const StageNow& now, double from, double goal, std::uint64_t rows, double reading) {
  const double level = from + (goal - from) * static_cast<double>(now.level + 1) / static_cast<double>(rows);
  return goal < from ? reading - level : level - reading;
}

/// Where a leg that a stress ends began: of cycles where the last one turned back.
double from_of(const Stage& stage, const StageNow& now) {
  if (stage.kind != StageKind::cyclic || now.leg == 0) return now.leg_from;
  return now.leg_from - sense(stage, now) * stage.amplitude;
}

}  // namespace

Landing leg_landing(const Programme& test) {
  const Stage& stage = stage_of(test);
  const auto goal = goal_of(stage, test.now);
  const bool looks = goal || stage.all || stage.until.void_ratio || stage.until.unbalanced_force ||
                     (stage.until.strain && !(stage.by_strain() && stage.kind != StageKind::cyclic)) ||
                     (stage.max_strain > 0 && (!stage.by_strain() || stage.kind == StageKind::cyclic));
  if (!looks) return {};
  const auto left = [&test, to = levels_to(stage, test.now)](const State& s) {
    const EndedBy end = leg_ended(test, s);
    if (end != EndedBy::nothing && end != EndedBy::time) return 0.0;
    const Stage& of = stage_of(test);
    const bool near_enough = of.all && test.now.level + 1 >= of.rows;  // the end itself is met by each axis
    if (!to || near_enough) return double{INFINITY};
    return left_to_level(test.now, from_of(of, test.now), *to, of.rows, towards_goal(test, s));
  };
  return {.left = left, .near = goal ? INFINITY : 0, .axis = stage.axis};
}

void count_row(Programme& test, const State& state) {
  const Stage& stage = stage_of(test);
  StageNow& now = test.now;
  now.row_time = state.time;
  const double end = leg_until(test), due = state.time + slack_of(now, end, state);
  while (row_until(test) <= due && now.row < 1u << 30u && row_until(test) < end) ++now.row;
  const auto to = levels_to(stage, now);
  if (!to) return;
  const double reading = towards_goal(test, state), from = from_of(stage, now);
  while (now.level < stage.rows && left_to_level(now, from, *to, stage.rows, reading) <= 0) ++now.level;
}

void end_leg(Programme& test, EndedBy end) {
  StageNow& now = test.now;
  now.leg_begun = false;
  if (end == EndedBy::cycles && ++now.leg < stage_of(test).legs()) return;
  now.begun = false, now.leg = 0, ++now.stage;
}

double stages_done(const Programme& test, const State& s) {
  const StageNow& now = test.now;
  const auto count = static_cast<double>(test.stages.size());
  if (now.stage >= test.stages.size()) return 1;
  const Stage& stage = stage_of(test);
  double part = 0;
  if (now.leg_begun) {
    const double end = leg_until(test);
    if (levels_to(stage, now))
      part = static_cast<double>(now.level) / static_cast<double>(stage.rows);
    else if (std::isfinite(end) && end > now.leg_began)
      part = (s.time - now.leg_began) / (end - now.leg_began);
  }
  const double legs = static_cast<double>(stage.legs());
  return (static_cast<double>(now.stage) + (static_cast<double>(now.leg) + std::clamp(part, 0.0, 1.0)) / legs) / count;
}

std::string unmet(const Programme& test, const State& s) {
  const Stage& stage = stage_of(test);
  const StageEnds& until = stage.until;
  std::vector<std::string> asked;
  const auto add = [&](const char* what, double goal, double is) {
    asked.push_back(fmt::format("{} of {:.4g} (it is {:.4g})", what, goal, is));
  };
  if (const auto goal = goal_of(stage, test.now)) {
    const bool turns = stage.kind == StageKind::cyclic;
    const bool of_deviator = turns ? stage.swing == Swing::deviator : !end_stress(stage, test.now);
    add(turns         ? of_deviator ? "a turn at a deviator in Pa" : "a turn at a stress in Pa"
        : of_deviator ? "a deviator in Pa"
                      : "a stress in Pa",
        *goal, towards_goal(test, s));
  }
  if (stage.all && until.stress) add("a stress in Pa", *until.stress, -normal_stresses(s).mean());
  if (until.strain) add("a strain", *until.strain, std::abs(stage_strain(test, s) - test.now.strain));
  if (until.void_ratio) add("a void ratio", *until.void_ratio, void_ratio(s));
  if (until.unbalanced_force) add("an unbalanced force", *until.unbalanced_force, unbalanced_force(s));
  const bool late = !too_far(stage, std::abs(stage_strain(test, s) - test.now.strain));
  return fmt::format("stage {} (\"{}\") has not met its end, {}, by a {} of {:.4g}{}", test.now.stage + 1, stage.name,
                     fmt::join(asked, " or "), late ? "time" : "strain",
                     late ? s.time - test.now.began : stage.max_strain,
                     late ? " s (max_time, or max_strain at strain_rate)" : " (max_strain)");
}

}  // namespace grus::dem
