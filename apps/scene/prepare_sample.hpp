// SPDX-License-Identifier: LGPL-3.0-or-later
// From a scene's grains to a state in which the test begins.
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// How far each stage of making a sample is; `what` names it. False: stop.
using StageWatch = std::function<bool(double done, const char* what)>;

/// Makes a packing that is pending, with neighbour list, forces and time step, and brings it under the pressure of the
/// scene's preparation, if it has one. Throws InputError where the packing cannot be, Unstable where the pressure is
/// not reached, Interrupted.
dem::State prepare_base(RveScene& scene, dem::Team& team, const StageWatch& watch = {});

/// From there to the state in which the test begins: with the grains' own friction to `stresses` along the axes (Pa,
/// compression-positive), if any are given; the clock and the ledger start at zero. Throws as prepare_base does.
dem::State start_from(dem::State base, const RveScene& scene, dem::Team& team, const StageWatch& watch = {},
                      const std::optional<dem::Vec3>& stresses = {});

/// What the preparation has made of the packing: stresses asked and reached, void ratios before and after. `cell`: the
/// scene with its packing made; null where it has no preparation.
nlohmann::json tell_preparation(const RveScene& cell, const dem::State& state,
                                const std::optional<dem::Vec3>& stresses = {});

/// A note where void ratios, which nobody asked for, have changed in any of these; empty: in none.
std::string note_of_preparations(const std::vector<nlohmann::json>& told);

/// Of several: how many, least and largest void ratios and pressures, the worst error of a stress; null: none is told.
nlohmann::json sum_of_preparations(const std::vector<nlohmann::json>& told);

/// Both stages, told in scene.prepared and scene.notes.
dem::State prepare_sample(RveScene& scene, dem::Team& team, const StageWatch& watch = {},
                          const std::optional<dem::Vec3>& stresses = {});

}  // namespace grus::app
