// SPDX-License-Identifier: LGPL-3.0-or-later
// Grains in packed spheres: spheres, ellipsoids of a mixture, hulls.
#pragma once

#include "dem/sample/recipe.hpp"

namespace grus::dem {

/// The grains in spheres, in the order of space: the parts of a mixture in turn, by their shares. `materials`: of each
/// sphere, instead of the parts'.
void put_spheres(const std::vector<Sphere>& spheres, const std::vector<Part>& parts, bool turned, const Model& model,
                 Grains& grains, const std::vector<std::uint8_t>& materials = {});

/// Those of a lattice.
void put_lattice(const Lattice& lattice, const Model& model, Grains& grains);

/// Those of a random packing in its bounds; `overlap`: the deepest of its spheres, over the smaller radius. Throws
/// InputError, Interrupted.
void put_random(const RandomPacking& packing, const Model& model, const Recipe& recipe, Team& team, const Watch& watch,
                Grains& grains, double& overlap);

}  // namespace grus::dem
