// SPDX-License-Identifier: LGPL-3.0-or-later
// From a scene's grains to a state in which the test begins.
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// Neighbour list, forces and time step; then the scene's preparation, if it has one. The state's clock and ledger
/// start at zero. Throws Unstable where the preparation does not reach its pressure.
dem::State prepare_sample(const RveScene& scene, dem::Team& team);

}  // namespace grus::app
