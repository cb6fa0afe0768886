// SPDX-License-Identifier: LGPL-3.0-or-later
// Packings of cells: [packing] kind = "voronoi", "prisms".
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// Makes the cells at once. `box` is given, or found here.
void read_voronoi(Table& table, RveScene& scene, std::uint8_t material, dem::Vec3& box);
void read_prisms(Table& table, RveScene& scene, std::uint8_t material, dem::Vec3& box);

}  // namespace grus::app
