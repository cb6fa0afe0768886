// SPDX-License-Identifier: LGPL-3.0-or-later
// [[packing.mixture]]: grains of several materials and shapes in one packing.
#pragma once

#include "apps/scene/reader.hpp"
#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// The parts of a packing in its bounds, one of `material` where nothing is mixed. Throws InputError.
std::vector<dem::Part> read_parts(Table& packing, const RveScene& scene, std::uint8_t material);

}  // namespace grus::app
