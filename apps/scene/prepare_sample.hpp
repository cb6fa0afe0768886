// SPDX-License-Identifier: LGPL-3.0-or-later
// From a scene's grains to a state in which the test begins.
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// How far each stage of making a sample is; `what` names it. False: stop.
using StageWatch = std::function<bool(double done, const char* what)>;

/// Makes a packing that is pending, then neighbour list, forces and time step, then the scene's preparation, if it has
/// one, and from there, with the grains' own friction, `stresses` along the axes (Pa, compression-positive), if any are
/// given. The state's clock and ledger start at zero. Throws InputError where the packing cannot be, Unstable where the
/// preparation does not reach its pressure, Interrupted.
dem::State prepare_sample(RveScene& scene, dem::Team& team, const StageWatch& watch = {},
                          const std::optional<dem::Vec3>& stresses = {});

}  // namespace grus::app
