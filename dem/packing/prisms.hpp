// SPDX-License-Identifier: LGPL-3.0-or-later
// Hexagonal prisms on their lattice (Saleme 2016): grains that meet in a plane mesh of triangles of centres.
#pragma once

#include "dem/packing/voronoi.hpp"

namespace grus::dem {

/// As many whole prisms as a box at the origin takes: `side` of the lattice's hexagons (m), axes along z, corners
/// towards +-y, layers of `thickness`. Prisms are smaller than their place: `gap` is left between two sides (m).
/// `round`: those within the cylinder along z that touches the box, about a prism in its middle. Throws InputError
/// where not one fits.
Tessellation hexagonal_prisms(const Vec3& box, double side, double thickness, double gap, bool round = false);

}  // namespace grus::dem
