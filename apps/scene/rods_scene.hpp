// SPDX-License-Identifier: LGPL-3.0-or-later
// Spheres that are bonded: [material.*.bond] of spheres, and grains filled with them.
#pragma once

#include "apps/scene/reader.hpp"
#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// The parallel bond of spheres.
dem::BondModel read_rods(Table t);

/// Which bonds of spheres there cannot be.
void refuse_rods(Table& material, const dem::Material& m, const std::string& contact);

/// Grains of a packing of spheres, each filled with smaller ones of a material.
dem::Agglomerates read_agglomerates(Table& packing, RveScene& scene, std::uint8_t material);

/// Spheres without a boundary that make up a cylinder along z: the key `round`.
bool read_round(Table& packing, const RveScene& scene);

}  // namespace grus::app
