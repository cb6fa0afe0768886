// SPDX-License-Identifier: LGPL-3.0-or-later
// The neighbour list of a run once it no longer holds: mended or made anew, whatever the stepper.
#pragma once

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// A pair that holds beyond touch must not fall from a list: its skin is no less than the furthest (m).
double contact_reach(const Model& model, const State& state);

/// The list has run out: `found` says how. A wider skin where lists take much of the time, a narrower one where
/// little; by counts of steps, so that no clock decides: a list costs some fifteen steps, to mend one some two. Throws
/// Unstable for grains that move by more than their radius in a step.
void renew_list(const Model& model, State& state, ListState found, bool indexed, Team& team);

}  // namespace grus::dem
