// SPDX-License-Identifier: LGPL-3.0-or-later
// Halves of a poly-ellipsoid (Zhang et al. 2015, 3.3.2): each keeps exactly 1 - rounding of its half's volume, lies
// inside the parent, keeps the parent's outer tip with its curvature, and touches its sibling in the parent's origin.
#pragma once

#include <array>

#include "dem/state/grains.hpp"
#include "dem/state/ledger.hpp"

namespace grus::dem {

struct Half {
  PolyEllipsoid shape;
  Vec3 origin;  // octant origin in the parent's geometry frame
};

/// Along + and - of the axis.
std::array<Half, 2> halves(const PolyEllipsoid& parent, int axis, double rounding);

/// Replaces grain i by its halves: the + half takes slot i, the - half is appended. Each moves with the parent's rigid
/// velocity field, density unchanged; what the halves do not hold goes to the fines.
void split_grain(Grains& grains, std::size_t i, int axis, double rounding, Fines& fines);

}  // namespace grus::dem
