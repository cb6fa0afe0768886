// SPDX-License-Identifier: LGPL-3.0-or-later
// A test of several stages: what each asks of model and loading, when its legs end, what it reads. Readings are
// compression-positive; of a simple shear its angle and its shear stress.
#pragma once

#include "dem/sample/programme.hpp"

namespace grus::dem {

/// A leg or a stage ends by one of these.
enum class EndedBy : std::uint8_t {
  nothing,
  stress,
  deviator,
  strain,
  void_ratio,
  time,
  unbalanced_force,
  cycles,
  limit
};
const char* name_of(EndedBy end);

/// Model and programme for the stage and the leg that the test is in: friction, damping and gravity of `own` where the
/// stage names none. No state is touched: a run that is resumed does the same.
void set_stage(const Model& own, Model& model, Programme& test);

/// Begins the stage that the test has come to after a row: notes where it begins, and stops walls and cell.
void begin_stage(const Model& own, Model& model, State& state, std::uint64_t row, Programme& test);

/// Begins its next leg: notes where it begins, and starts walls and cell.
void begin_leg(const Model& own, Model& model, State& state, Programme& test);

/// Way (compression-positive, of the first size) and stress (Pa) along the axis, and what a cycle turns back by.
double stage_strain(const Programme& test, const State& state);
double stage_stress(const Programme& test, const State& state);
double stage_swing(const Programme& test, const State& state);

/// Force that is left on the grains, weight included, on average over that of contacts and bonds; infinite where
/// nothing touches, as nothing is at rest then.
double unbalanced_force(const State& state);

/// What ends the leg in this state; a limit where the stage has failed to get there.
EndedBy leg_ended(const Programme& test, const State& state);

/// It ends no later than then, or its next row is due (s).
double leg_until(const Programme& test);
double row_until(const Programme& test);

/// How to meet what ends the leg, or its next row, if a stress does. What is given must outlive it.
Landing leg_landing(const Programme& test);

/// A row of the leg has been written in this state.
void count_row(Programme& test, const State& state);

/// The leg is over, and with its last one, or by another end than a cycle's, the stage: to the next.
void end_leg(Programme& test, EndedBy end);

/// The part of the test that is done, by the parts of its legs.
double stages_done(const Programme& test, const State& state);

/// What was asked and what there is, of a stage that has failed to get there.
std::string unmet(const Programme& test, const State& state);

}  // namespace grus::dem
