// SPDX-License-Identifier: LGPL-3.0-or-later
// Grains made of Voronoi cells.
#pragma once

#include "dem/packing/voronoi.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// Fills every grain with `count` Voronoi cells, which are its cluster; grains become polyhedra of their volume. Throws
/// InputError.
Tessellation fill_grains(const Grains& parents, std::size_t count, int rounds, std::uint64_t seed, Team& team);

/// Deals the Voronoi cells of a space to `count` clusters: each goes to the nearest of so many relaxed seeds.
void deal_to_clusters(const TessellationSpace& space, std::size_t count, std::uint64_t seed, Team& team,
                      Tessellation& cells);

}  // namespace grus::dem
