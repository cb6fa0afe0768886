// SPDX-License-Identifier: LGPL-3.0-or-later
// A state that comes from a file: what a step trusts - numbers of rows, indices, finite values - is looked at once, so
// that a damaged one is refused instead of leading anywhere.
#pragma once

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// Throws InputError, "checkpoint is damaged: ...", for a state that no run of this model can have left. Changes
/// nothing.
void check_state(const Model& model, const State& state);

}  // namespace grus::dem
