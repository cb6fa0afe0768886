// SPDX-License-Identifier: LGPL-3.0-or-later
// An RVE that waits for its next increment, reduced to what has to be kept: the motions of its grains and the histories
// of contacts that touch. Lists, forces and what follows from the shapes are made again when it wakes: some 0.3 kB a
// grain instead of 1.1. RVEs on whose bits a resumed run depends rest at every commit, whether saved or not.
#pragma once

#include "dem/base/parallel.hpp"
#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// The state reduced, beside it as it is: what is not kept is never copied, so that many RVEs leave no holes in
/// memory.
State resting_copy(State& state);

/// The state reduced; one that rests already stays as it is. It can be copied, saved and woken, nothing else.
State at_rest(State state);

/// Makes a resting state whole: its list is of where the grains are now, its forces are those of this instant. What
/// friction sheds, as a sliding contact meets its limit without the dashpots' part, is booked. Others stay as they are.
void awaken(const Model& model, State& state, Team& team);

}  // namespace grus::dem
