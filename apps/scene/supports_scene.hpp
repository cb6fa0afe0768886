// SPDX-License-Identifier: LGPL-3.0-or-later
// Supports and loads of a sample of Voronoi cells: [[clamp]], [[load]], glued walls, rollers.
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// [[clamp]] and [[load]].
void read_supports(Table& scene_table, RveScene& scene);

/// [boundary] bonded: Voronoi cells are glued to the walls of their box.
void read_glue(Table& boundary, RveScene& scene);

/// Neither bounds nor walls nor clamps: platens and rollers bring their own.
bool open_and_free(const RveScene& scene);

/// [loading] kind = "platens", "rollers".
void read_platens(Table& table, RveScene& scene);
void read_rollers(Table& table, RveScene& scene);

}  // namespace grus::app
