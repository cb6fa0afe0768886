// SPDX-License-Identifier: LGPL-3.0-or-later
// Spheres held together by parallel bonds, round rods of cement beside their contacts (Potyondy and Cundall 2004).
#pragma once

#include <span>

#include "dem/base/parallel.hpp"
#include "dem/base/watch.hpp"
#include "dem/packing/packing.hpp"
#include "dem/packing/voronoi_grains.hpp"

namespace grus::dem {

/// Some material's bonds are of spheres.
bool bonds_spheres(const Model& model);

/// Bonds all spheres whose materials have such bonds and that are no further apart than these reach, at rest as they
/// are. `body`: by the number of a grain, those of different bodies are not bonded; empty: all are one.
BondedFaces bond_spheres(const Model& model, std::span<const Index> body, State& state, Team& team);

/// Smaller spheres in every one of some: those of one dense random packing that lie in it, each time about another
/// point and turned. `body`: which sphere each is in. Throws InputError where a sphere holds none.
std::vector<Sphere> spheres_in_spheres(std::span<const Sphere> parents, const RadiusDistribution& radius,
                                       double solid_fraction, std::uint64_t seed, Team& team, const Watch& watch,
                                       std::vector<Index>& body);

}  // namespace grus::dem
