// SPDX-License-Identifier: LGPL-3.0-or-later
// [[wall]]: walls one by one, and sides of a box that move or press by themselves.
#pragma once

#include "apps/scene/reader.hpp"
#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// One of them into the recipe; what it is to press with into the test's loading.
void read_wall(Table table, RveScene& scene);

/// Walls that move by themselves are of no test that moves them.
void refuse_own_motion(const Table& loading, const std::string& key, const RveScene& scene);

}  // namespace grus::app
