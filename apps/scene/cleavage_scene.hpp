// SPDX-License-Identifier: LGPL-3.0-or-later
// [material.NAME.fracture] model = "cleavage".
#pragma once

#include "apps/scene/hulls_scene.hpp"

namespace grus::app {

/// Reads what cleavage has beside criteria and limits of all models: toughness, planes, crystals, the bond of a fresh
/// face.
void read_cleavage(Table& table, const std::optional<dem::Elasticity>& elasticity, dem::FractureModel& model);

}  // namespace grus::app
