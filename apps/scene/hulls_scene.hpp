// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls of a scene: [[grain]] shape = "hull", the bonds between Voronoi cells.
#pragma once

#include "apps/scene/rve_scene.hpp"
#include "dem/sample/network.hpp"

namespace grus::app {

/// [material.NAME.bond]; `elasticity`: of the solid, if it is told.
dem::BondModel read_bond(Table table, double friction, std::optional<dem::Elasticity>& elasticity);

/// Vertices or box of a hull.
void read_hull(Table& table, dem::ListedGrain& grain);

/// Hulls meet hulls and walls alone, by one law: refuses all else.
void check_hulls(const Table& table, const RveScene& scene);

}  // namespace grus::app
