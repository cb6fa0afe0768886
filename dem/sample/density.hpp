// SPDX-License-Identifier: LGPL-3.0-or-later
// A preparation that leaves a void ratio at its pressure: the friction that does is searched for.
#pragma once

#include "dem/sample/prepare.hpp"

namespace grus::dem {

/// A void ratio is met within this.
inline constexpr double density_tolerance = 0.003;

/// Compresses a state as it was made, again and again, with the friction between grains that leaves the preparation's
/// void ratio: more friction, more voids. `found`: what it was. Throws InputError with the range that can be reached
/// where the void ratio is beyond, else as `compressed` does.
State compressed_to_density(const State& made, const Model& model, const Preparation& preparation, Team& team,
                            const StageWatch& watch, FoundDensity& found);

}  // namespace grus::dem
