// SPDX-License-Identifier: LGPL-3.0-or-later
// What is there at the start: grains, walls, cell.
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// Reads [packing] or [[grain]], [[wall]] and [boundary] into scene.state; rigid walls add materials to the model.
void read_sample(Table& table, RveScene& scene);

/// Two rigid platens that touch the grains along an axis; the upper one moves at `speed` (m/s) towards the lower.
void add_platens(RveScene& scene, int axis, double speed, double friction);

}  // namespace grus::app
