// SPDX-License-Identifier: LGPL-3.0-or-later
// From a sample to the state in which a test begins.
#pragma once

#include "dem/sample/make.hpp"

namespace grus::dem {

/// How far each stage of a preparation is; `what` names it. False: stop.
using StageWatch = std::function<bool(double done, const char* what)>;

/// The watch of one stage.
Watch stage_of(const StageWatch& watch, const char* what);

/// The friction that left the void ratio that was asked for, and how many were tried.
struct FoundDensity {
  double friction = 0;
  int tries = 0;
};

/// Brings a state as it was made under the pressure of its preparation, if it has one, and to its void ratio, if that
/// is asked for. Throws Unstable where the pressure is not reached, InputError where the void ratio cannot be,
/// Interrupted.
State compressed(State state, const Model& model, const std::optional<Preparation>& preparation, Team& team,
                 const StageWatch& watch = {}, FoundDensity* found = nullptr);

/// From there to the state in which the test begins: with the grains' own friction to `stresses` along the axes (Pa,
/// compression-positive), if any are given; the clock and the ledger start at zero. Throws as `compressed` does.
State start_from(State base, const Model& model, const std::optional<Preparation>& preparation, Team& team,
                 const StageWatch& watch = {}, const std::optional<Vec3>& stresses = {});

/// Both, of a recipe: the state of `make`, ready to be loaded, with neighbour list, forces and time step.
State make_ready(const Model& model, const Recipe& recipe, Team& team, const StageWatch& watch = {});

/// Why no packing of such grains can bear a pressure (Pa); empty: some may. The model has its pair laws.
std::string unbearable(const Model& model, const Recipe& recipe, double pressure);

}  // namespace grus::dem
