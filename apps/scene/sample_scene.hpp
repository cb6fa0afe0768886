// SPDX-License-Identifier: LGPL-3.0-or-later
// What is there at the start: grains, walls, cell.
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// Reads [packing] or [[grain]], [[wall]] and [boundary] into scene.state; rigid walls add materials to the model.
void read_sample(Table& table, RveScene& scene);

/// Makes a packing that is pending. Throws InputError with file, line and key, Interrupted where the watch says so.
void make_sample(RveScene& scene, dem::Team& team, const dem::Watch& watch);

/// A piece of the sample of some thousand grains, where it is larger (true): enough to tell the time step and the cost
/// of a grain.
bool make_smaller(RveScene& scene);

/// A rigid material for walls; its friction replaces that of the grains unless NaN.
std::uint8_t rigid_material(const Table& at, dem::Model& model, double friction);

/// Two rigid platens that touch the grains along an axis; the upper one moves at `speed` (m/s) towards the lower.
void add_platens(const Table& at, RveScene& scene, int axis, double speed, double friction);

}  // namespace grus::app
