// SPDX-License-Identifier: LGPL-3.0-or-later
// How a state goes on in time. A model names its stepper; the explicit one (leapfrog) is the first.
#pragma once

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

struct Stepper {
  void (*prepare)(const Model& model, State& state, Team& team);
  void (*update_time_step)(const Model& model, State& state, Team& team);
  std::uint64_t (*run)(const Model& model, State& state, std::uint64_t count, Team& team);
  bool long_steps = false;  // one of them may pass a stress that is sought by far
};

/// Makes a state ready to run: columns that the model needs, neighbour list, forces, time step, energy at the start.
inline void prepare(const Model& model, State& state, Team& team) { model.stepper->prepare(model, state, team); }

/// Estimates the critical step if it is due and sets state.dt to its safe part (or to the scene's fixed step).
inline void update_time_step(const Model& model, State& state, Team& team) {
  model.stepper->update_time_step(model, state, team);
}

/// Runs up to `count` steps of state.dt and leaves positions, velocities and forces at the same instant. Breakage, list
/// rebuilds and boundary motion included. Stops after a breakage, so that the caller can ask for a new time step;
/// returns the number of steps done. Throws Unstable on NaN.
inline std::uint64_t run_steps(const Model& model, State& state, std::uint64_t count, Team& team) {
  return model.stepper->run(model, state, count, team);
}

}  // namespace grus::dem
