// SPDX-License-Identifier: LGPL-3.0-or-later
// Packings of Voronoi cells: [packing] kind = "voronoi", "prisms".
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// The recipe's box is given, or found here.
void read_voronoi(Table& table, RveScene& scene, std::uint8_t material);
void read_prisms(Table& table, RveScene& scene, std::uint8_t material);

}  // namespace grus::app
