// SPDX-License-Identifier: LGPL-3.0-or-later
// What holds and loads a sample of cells: [[clamp]], [[load]], glued walls, rollers.
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// [[clamp]] and [[load]].
void read_supports(Table& scene_table, RveScene& scene);

/// [boundary] bonded: cells are glued to the walls of their box.
void glue_to_walls(Table& boundary, RveScene& scene);

/// [loading] kind = "rollers".
void read_rollers(Table& table, RveScene& scene);

}  // namespace grus::app
