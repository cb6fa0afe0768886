// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/servo.hpp"

#include <algorithm>

#include "dem/rve/press.hpp"
#include "dem/rve/stepper.hpp"

namespace grus::dem {

namespace {

/// Stresses of the two axes beside the driven one, of which the middle one is on the way from the third to it.
void share_by_ratio(const Loading& loading, const Vec3& stress, std::array<AxisControl, 3>& axes) {
  const double b = *loading.ratio;
  int driven = 0;
  while (driven == loading.middle || axes[static_cast<std::size_t>(driven)].stress) ++driven;
  AxisControl& third = axes[static_cast<std::size_t>(3 - driven - loading.middle)];
  if (loading.mean) third.stress = (3 * *loading.mean - (1 + b) * stress[driven]) / (2 - b);
  axes[static_cast<std::size_t>(loading.middle)].stress = *third.stress + b * (stress[driven] - *third.stress);
}

}  // namespace

std::array<AxisControl, 3> controls(const Loading& loading, const Vec3& stress, double time) {
  std::array<AxisControl, 3> axes = loading.axes;
  if (!loading.mean && !loading.first) return axes;
  if (time < loading.consolidation) {
    const double reached = 0.8 * loading.consolidation, part = time < reached ? time / reached : 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const double goal = loading.first ? (*loading.first)[static_cast<int>(k)] : *loading.mean;
      axes[k] = {.strain_rate = 0,
                 .stress = loading.prepared + (goal - loading.prepared) * part,
                 .max_rate = axes[k].max_rate};
    }
    return axes;
  }
  if (loading.ratio) {
    share_by_ratio(loading, stress, axes);
  } else if (loading.mean) {
    double sought = *loading.mean, rate = 0;
    for (int k = 0; k < 3; ++k) {
      const AxisControl& axis = axes[static_cast<std::size_t>(k)];
      if (axis.stress) continue;
      sought = 0.5 * (3 * *loading.mean - stress[k]);
      rate = -0.5 * axis.strain_rate;  // an isotropic elastic sample keeps its volume under a constant mean stress
    }
    for (AxisControl& axis : axes)
      if (axis.stress) axis = {.strain_rate = rate, .stress = sought, .max_rate = axis.max_rate};
  }
  return axes;
}

double stress_asked(const AxisControl& axis, double time) { return *axis.stress + axis.stress_rate * time; }

double fastest_rate(const State& state, const AxisControl& axis, double pressure) {
  constexpr double fastest = 0.03;  // inertial number
  return std::max(axis.max_rate, fastest / inertial_number(state, 1, pressure));
}

namespace {

/// Change of a stress that must hold while another axis is driven, from one correction to the next, were the sample as
/// stiff as its contacts: a cell strains all of them at once, so that a gap may be closed in one.
constexpr double change = 0.02;

/// Closings in which a gap that stays becomes drift.
constexpr double learning = 8;

/// Steps in which a gap that is sought is closed, if the tangent holds: explicit ones are far shorter than what a
/// sample needs to answer; one that solves its contacts answers at once, and the step's length goes by the rate.
double closing_steps(const Model& model) { return model.stepper->long_steps ? 4 : 200; }

bool seeks(const Loading& loading) {
  return std::any_of(loading.axes.begin(), loading.axes.end(), [](const auto& a) { return a.stress.has_value(); });
}

Vec3 stiffness_of(const Model& model, const State& state) {
  return contact_stiffness_tangent(model, state).diagonal().head<3>();
}

Vec3 seeking_rates(const Model& model, const State& state, const Loading& loading) {
  Vec3 rates, stiffest = Vec3::Zero(), stress = Vec3::Zero();
  if (seeks(loading)) {
    const Measurement m = measure(model, state);
    stress = state.boundary.cell.everywhere() ? m.stress.diagonal() : m.wall_stress.diagonal();
    stiffest = stiffness_of(model, state);
  }
  const std::array<AxisControl, 3> axes = controls(loading, stress, state.time);
  for (int k = 0; k < 3; ++k) {
    const AxisControl& axis = axes[static_cast<std::size_t>(k)];
    rates[k] = axis.strain_rate;
    if (!axis.stress) continue;
    const double now = stress[k];
    // A loose sample has no tangent and moves at the bound.
    const double wanted = stress_asked(axis, state.time);
    const double stiffness = std::max(stiffest[k], 10 * std::abs(wanted));
    const double gap = wanted - now;  // of nothing in a sample that nothing holds yet: it waits
    if (gap != 0)
      rates[k] += std::clamp(gap / (stiffness * closing_steps(model) * state.dt), -axis.max_rate, axis.max_rate);
  }
  return rates;
}

Vec3 holding_rates(const Model& model, State& state, const Loading& loading, std::uint64_t& steps) {
  Servo& servo = state.servo;
  const double elapsed = state.time - servo.at;
  servo.at = state.time;
  if (state.steps >= servo.stale_at) {
    servo.stiffness = stiffness_of(model, state), servo.viscosity = contact_viscosity(model, state);
    servo.stale_at = state.steps + servo_steps;
  }
  const Vec3 stress = normal_stresses(state);
  const std::array<AxisControl, 3> axes = controls(loading, stress, state.time);
  Vec3 rates = Vec3::Zero(), wanted = rates, stiffness = servo.stiffness;
  double driven = 0, soonest = INFINITY;  // the strain in which the stress of some axis changes by itself
  for (int k = 0; k < 3; ++k) {
    const AxisControl& axis = axes[static_cast<std::size_t>(k)];
    if (!axis.stress) {
      rates[k] = axis.strain_rate;
      driven = std::max(driven, std::abs(axis.strain_rate));
      continue;
    }
    wanted[k] = stress_asked(axis, state.time);
    stiffness[k] = std::max(stiffness[k], 10 * std::abs(wanted[k]));  // of a loose sample
    soonest = std::min(soonest, std::abs(wanted[k]) / stiffness[k]);
  }
  const double often = driven > 0 ? change * soonest / (driven * state.dt) : INFINITY;
  steps = static_cast<std::uint64_t>(std::clamp(often, 1.0, static_cast<double>(servo_steps)));
  for (int k = 0; k < 3; ++k) {
    const AxisControl& axis = axes[static_cast<std::size_t>(k)];
    if (!axis.stress) continue;
    const double gap = wanted[k] - stress[k];
    if (gap == 0) continue;  // of nothing in a sample that nothing holds yet: it waits
    const double closing = static_cast<double>(steps) * state.dt;
    const double most = fastest_rate(state, axis, std::max(std::abs(wanted[k]), std::abs(stress[k])));
    // Dashpots answer the change of the rate: what they press by the rate until now is no stress that lasts.
    const double viscous = servo.viscosity[k], slope = stiffness[k] * closing + viscous;
    double& drift = servo.drift[k];
    drift = std::clamp(drift + gap / slope * std::min(1.0, elapsed / (learning * closing)), -most, most);
    const double eased = axis_rate(state, loading, k) - axis.strain_rate - drift;
    rates[k] = axis.strain_rate + std::clamp(drift + (gap + viscous * eased) / slope, -most, most);
  }
  return rates;
}

}  // namespace

Vec3 servo_rates(const Model& model, State& state, const Loading& loading, std::uint64_t& steps) {
  if (loading.holds) return holding_rates(model, state, loading, steps);
  steps = model.stepper->long_steps ? 1 : servo_steps;
  return seeking_rates(model, state, loading);
}

double stress_error(const State& state, const Loading& loading, const Measurement& m) {
  const Vec3 stress = state.boundary.cell.everywhere() ? m.stress.diagonal() : m.wall_stress.diagonal();
  const std::array<AxisControl, 3> axes = controls(loading, stress, state.time);
  double worst = NAN;
  auto add = [&](double now, double sought) {
    const double off = std::abs(now / sought - 1);
    if (sought != 0 && !(off <= worst)) worst = off;
  };
  for (int k = 0; k < 3; ++k) {
    const AxisControl& axis = axes[static_cast<std::size_t>(k)];
    if (axis.stress) add(stress[k], stress_asked(axis, state.time));
  }
  if (loading.mean && state.time >= loading.consolidation) add(stress.mean(), *loading.mean);
  for (const WallControl& control : loading.walls) {
    const WallForce now = force_of(state, control);
    add(now.force, now.asked);
  }
  return worst;
}

}  // namespace grus::dem
