// SPDX-License-Identifier: LGPL-3.0-or-later
// [[packing.mixture]]: grains of several materials and shapes in one packing.
#pragma once

#include "apps/scene/reader.hpp"
#include "apps/scene/rve_scene.hpp"
#include "dem/packing/packing.hpp"

namespace grus::app {

/// The parts of a packing in a container, one of `material` where nothing is mixed. Throws InputError.
std::vector<PendingPacking::Part> read_parts(Table& packing, const RveScene& scene, dem::Container container,
                                             std::uint8_t material);

/// How much larger than a sphere of its volume the sphere about each grain is, in turn; empty where all are spheres.
std::vector<double> reaches(const std::vector<PendingPacking::Part>& parts);

/// The grains in a packing's spheres, in the order of space.
void put_grains(const dem::Packing& packing, const std::vector<PendingPacking::Part>& parts, bool turned,
                RveScene& scene);

}  // namespace grus::app
