// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls of a scene: [[grain]] shape = "hull", the bonds between cells.
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// [material.NAME.bond].
dem::BondModel read_bond(Table table, double friction);

/// Vertices or box of a hull, as a row of the grains' hulls; its mass centre becomes the position, and its axes are
/// turned into the orientation.
void read_hull(Table& table, dem::Grains& grains, dem::GrainSpec& spec);

/// Hulls meet hulls and walls alone, by one law: refuses all else.
void check_hulls(const Table& table, const RveScene& scene);

}  // namespace grus::app
