// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls of a scene: [[grain]] shape = "hull", the bonds between cells.
#pragma once

#include "apps/scene/rve_scene.hpp"
#include "dem/packing/random_hulls.hpp"

namespace grus::app {

/// Of a solid, if its scene tells it: modulus (Pa) and Poisson's ratio.
struct Elasticity {
  double modulus, poissons_ratio;
};

/// [material.NAME.bond].
dem::BondModel read_bond(Table table, double friction, std::optional<Elasticity>& elasticity);

/// Vertices or box of a hull, as a row of the grains' hulls; its mass centre becomes the position, and its axes are
/// turned into the orientation. Points that are no corners are told in `notes`.
void read_hull(Table& table, dem::Grains& grains, dem::GrainSpec& spec, std::vector<std::string>& notes);

/// A hull into every sphere of a packing: shape i of `hulls` in turn, in the sphere that holds it. Equal ones share a
/// row. Throws InputError.
void put_hulls(const dem::Packing& packing, const std::vector<dem::UnitHull>& hulls, std::uint8_t material, bool turned,
               RveScene& scene);

/// Hulls meet hulls and walls alone, by one law: refuses all else.
void check_hulls(const Table& table, const RveScene& scene);

}  // namespace grus::app
