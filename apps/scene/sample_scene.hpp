// SPDX-License-Identifier: LGPL-3.0-or-later
// Grains, walls and periodic cell, as they are at the start.
#pragma once

#include <span>

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// Reads [packing] or [[grain]], [[wall]] and [boundary] into the recipe; rigid walls add materials to the model.
/// `record`: of the whole scene, in which materials are named.
void read_sample(Table& table, const nlohmann::json& record, RveScene& scene);

/// A rigid material for walls; its friction replaces that of the grains unless NaN.
std::uint8_t rigid_material(const Table& at, dem::Model& model, double friction);

/// Another material of the model, for walls or what moves with them; which it is.
std::uint8_t add_material(const Table& at, dem::Model& model, dem::Material material);

/// A note where sides of a box differ by a factor of a thousand: one in another unit is a slip that nothing refuses.
void tell_uneven(std::span<const double> sides, std::vector<std::string>& notes);

}  // namespace grus::app
