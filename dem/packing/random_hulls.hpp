// SPDX-License-Identifier: LGPL-3.0-or-later
// Angular grains: cells of a periodic Voronoi mesh, each on its own.
#pragma once

#include "dem/packing/voronoi.hpp"

namespace grus::dem {

/// A shape of the volume of the unit sphere about its mass centre, and the radius of the sphere about that which holds
/// it.
struct UnitHull {
  Polyhedron body;
  double reach;
};

inline constexpr std::size_t random_hull_shapes = 216;

/// Up to `random_hull_shapes` of them. `rounds` of relaxation: the more, the rounder; `aspect`: lengths along three
/// axes that all Voronoi cells are stretched by. Cells of more faces or corners than a hull may have are left out.
std::vector<UnitHull> random_hulls(int rounds, const Vec3& aspect, std::uint64_t seed, Team& team);

}  // namespace grus::dem
