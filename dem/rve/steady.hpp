// SPDX-License-Identifier: LGPL-3.0-or-later
// A periodic cell that is carried on and on, quasi-statically by its rate alone: no relaxation, no trial, no way back.
#pragma once

#include "dem/rve/rve.hpp"

namespace grus::dem {

/// Advances an RVE along F = R U: along U for as long as its keys want (strain_per_step, inertial_number), a DEM step
/// at least, free of anybody else's time. That time follows the largest of the recent increments, not this one: the
/// rate is in proportion to the increment, and what the grains answer to its sign is damping, not a jump. R is kept in
/// `steady.turn` and the state stays in its own frame: objective exactly, and nothing is turned. Tells the Love-Weber
/// stress that would be left without contact dashpots: their part is of the cell's own rate, which is nobody's, and its
/// work is told apart (haste). Contact-stiffness tangent if asked. Throws Unstable.
Response respond_steadily(const Model& model, const QuasiStatic& options, State& state, Steady& steady,
                          const Mat3& deformation, bool tangent, Team& team);

/// The state as it stands in space: turned by steady.turn.
State in_space(State state, const Steady& steady);

}  // namespace grus::dem
