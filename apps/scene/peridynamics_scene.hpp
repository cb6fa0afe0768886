// SPDX-License-Identifier: LGPL-3.0-or-later
// [material.NAME.fracture] model = "peridynamics".
#pragma once

#include "apps/scene/hulls_scene.hpp"

namespace grus::app {

/// Reads what peridynamics has beside how strengths scatter and who may break: toughness, the lattice, when grains are
/// tested.
void read_peridynamics(Table& table, const dem::Material& material, const std::optional<dem::Elasticity>& elasticity,
                       dem::FractureModel& model);

}  // namespace grus::app
