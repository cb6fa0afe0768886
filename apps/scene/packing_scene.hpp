// SPDX-License-Identifier: LGPL-3.0-or-later
// [packing], and what it shares with [[grain]].
#pragma once

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

inline dem::Vec3 vector3(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

/// Lengths of a body along three axes, relative; one where the key `aspect` is absent.
dem::Vec3 read_aspect(Table& table);

/// The distribution that the table `radius` of a packing tells.
dem::RadiusDistribution read_radius(Table& packing);

/// Index of a material by its name.
std::uint8_t material_of(Table& table, const dem::Model& model, const std::string& name, const char* key = "material");

/// Refuses a box that bounds no upright cylinder.
void check_cylinder(const Table& table, const dem::Vec3& box);

/// Refuses grains whose mass or inertia no number holds, and those that attraction alone would press so deep into each
/// other that their circles of contact are no longer small against them.
void check_mass(const Table& table, const dem::Material& material, double radius, const std::string& key);

/// Reads the table into the recipe: what its grains are, and the box, where it is told or follows.
void read_packing(Table table, RveScene& scene);

}  // namespace grus::app
