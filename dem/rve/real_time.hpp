// SPDX-License-Identifier: LGPL-3.0-or-later
// A periodic cell carried through a deformation in real time: no relaxation, micro-inertia is real.
#pragma once

#include <functional>

#include "dem/rve/rve.hpp"

namespace grus::dem {

/// Carries the cell along F = R U in exactly `duration` (s): along U at constant rate, then everything is turned by R.
/// The cell keeps its rate, so that the next piece changes velocities by the difference only.
void deform_in_time(const Model& model, State& state, const Mat3& deformation, double duration, Team& team);

/// Along a stretch `u` (symmetric) only; nothing is turned. `begun`: called after the first DEM step, which has taken
/// so large a part of the duration.
void stretch_in_time(const Model& model, State& state, const Mat3& u, double duration, Team& team,
                     const std::function<void(double)>& begun = {});

/// The same as a response: Love-Weber stress at the end of the piece; tangent only if asked. Throws Unstable.
Response respond_in_time(const Model& model, State& state, const Mat3& deformation, double duration, bool tangent,
                         Team& team);

}  // namespace grus::dem
