// SPDX-License-Identifier: LGPL-3.0-or-later
// What a run of grus-rve tells of its time step: which grain set it when it had fallen, and the inertia that was given
// for it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "apps/rve/error_estimates.hpp"
#include "dem/rve/critical_grain.hpp"

namespace grus::app {

/// A step that has fallen by more than this is told of, with its grain.
inline constexpr double told_fall = 10;

/// Local inertial numbers above this are told of where inertia has been given for the step.
inline constexpr double most_inertial_number = 0.01;

/// So is inertia of all grains above this, over that of the solids: of tests whose pressure nobody knows, too.
inline constexpr double most_added = 1;

/// A row at so many times the pressure of the one that told the largest inertial number tells it anew: grains that
/// barely touch have no inertial number.
inline constexpr double barely_loaded = 100;

struct StepTold {
  double first = 0, least = 0, least_at = 0;  // s: steps of the first row and of the least so far, and the time of that
  dem::CriticalGrain slowest;                 // then, once it has fallen by told_fall
  Estimate mass, moment;                      // added, over the solids'
  double heavier = 0, slower = 0;             // shares of the grains with more mass, larger moments, in the last row
  double inertial_number = 0;                 // the largest of a grain so far
  double pressure_then = 0;                   // Pa; 0: no row has told a pressure

  /// A row; `rate` (1/s) and `pressure` (Pa) of the test.
  void add(const dem::Model& model, const dem::State& state, double rate, double pressure);
  /// Of the inertia.
  nlohmann::json json() const;
  /// What the user should know; `by_step`: inertia has been given for the step.
  std::vector<std::string> notes(bool by_step, bool solved = false) const;
};

}  // namespace grus::app
