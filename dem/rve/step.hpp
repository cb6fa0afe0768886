// SPDX-License-Identifier: LGPL-3.0-or-later
// The step loop: all the physics of a step, in order.
#pragma once

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// Makes a state ready to run: columns that the model needs, neighbour list, forces, time step, energy at the start.
void prepare(const Model& model, State& state, Team& team);

/// Runs up to `count` steps of state.dt and leaves positions, velocities and forces at the same instant. Breakage, list
/// rebuilds and boundary motion included. Stops after a breakage, so that the caller can ask for a new time step;
/// returns the number of steps done. Throws Unstable on NaN.
std::uint64_t run_steps(const Model& model, State& state, std::uint64_t count, Team& team);

/// Estimates the critical step if it is due and sets state.dt to its safe part (or to the scene's fixed step).
void update_time_step(const Model& model, State& state);

/// Changes the rate of the cell; grains get the change of the affine velocity at their place, booked as work.
void set_cell_rate(State& state, const Mat3& rate);

/// Turns everything by a rotation about the origin: the frame changes, nothing else.
void rotate(State& state, const Mat3& rotation);

/// Kinetic, contact and spring energy (J).
double stored_energy(const Model& model, const State& state);

/// Throws Unstable if the overlap or energy error has passed the model's bounds, or a number is not finite.
void check_sanity(const Model& model, const State& state);

}  // namespace grus::dem
