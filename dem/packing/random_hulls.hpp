// SPDX-License-Identifier: LGPL-3.0-or-later
// Angular grains: cells of a periodic Voronoi mesh, each on its own; or balls of planes, round until they break.
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

/// Planes of the ball that a hull's room holds: it has 60 corners, with 80 faces of an icosphere's 42 it would not fit.
inline constexpr int ball_planes = 32;

/// The body whose 32 planes touch one sphere, across the corners (0, 1, g), (0, 1/g, g), (1, 1, 1), ... of an
/// icosahedron and a dodecahedron in one cube, g the golden ratio: all faces are as far out, 0.951490 of the radius of
/// the sphere of equal volume, which is its sphericity; the furthest corner is 1.129864 of it away. Stretched by
/// `aspect` as above.
UnitHull ball_of_planes(const Vec3& aspect);

}  // namespace grus::dem
