// SPDX-License-Identifier: LGPL-3.0-or-later
// Walls of a box that press with a force, as light plates with a pressure behind them would.
#pragma once

#include "dem/rve/loading.hpp"

namespace grus::dem {

/// Sets the velocities of all walls of a box for the next step. Both walls of an axis that seeks a stress press with it
/// on what is before them: each follows the grains that touch it, and closes the gap to its force by the stiffness and
/// the dashpots of those contacts (and of the bonds that glue grains to it), however fast the sample yields. They carry
/// its weight between them, and bring it to rest where it drifts. Of an axis that is driven the first wall stays.
void press_walls(const Model& model, State& state, const Loading& loading);

/// The same of one plane that seeks a stress by itself; along its plane it goes as it does.
void press_wall(const Model& model, State& state, const WallControl& control);

/// What presses such a wall outward now, and what it is asked to press with (N).
struct WallForce {
  double force = 0, asked = 0;
};
WallForce force_of(const State& state, const WallControl& control);

}  // namespace grus::dem
