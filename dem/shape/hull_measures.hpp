// SPDX-License-Identifier: LGPL-3.0-or-later
// How round a hull is.
#pragma once

#include "dem/shape/hull_store.hpp"

namespace grus::dem {

/// Surface of the sphere of equal volume over its own (Wadell 1932): 1 round, of a cube 0.806.
double sphericity(const HullRow& row);

/// Mean over the edges, weighted by their lengths, of the angle by which the surface turns there times how far out the
/// edge is: the distance of its middle from the mass centre over that of the nearest face (Lees 1964, who has corners
/// of outlines). Of a cube pi / sqrt 2, of what is round 0.
double angularity(const HullView& hull);

}  // namespace grus::dem
