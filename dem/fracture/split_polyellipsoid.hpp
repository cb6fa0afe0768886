// SPDX-License-Identifier: LGPL-3.0-or-later
// Halves of a poly-ellipsoid (Zhang et al. 2015, 3.3.2): each keeps exactly 1 - rounding of its half's volume, lies
// inside the parent, keeps the parent's outer tip with its curvature, and touches its sibling in the parent's origin.
#pragma once

#include <array>

#include "dem/fracture/criteria.hpp"
#include "dem/state/grains.hpp"
#include "dem/state/ledger.hpp"

namespace grus::dem {

struct Half {
  PolyEllipsoid shape;
  Vec3 origin;  // octant origin in the parent's geometry frame
};

/// An edge without rounding has no Hertz radius: halves with a smaller rounding get this one (0.1 % of the volume), and
/// a rounding of 0 keeps their mass exact by density.
inline constexpr double least_rounding = 1e-3;

/// Along + and - of the axis.
std::array<Half, 2> halves(const PolyEllipsoid& parent, int axis, double rounding);

/// Replaces grain i by its halves: the + half takes slot i, the - half is appended. Each moves with the parent's rigid
/// velocity field. What the halves do not hold goes to the fines: with the density unchanged (1 - rounding) of the mass
/// stays, with `keep_mass` the density rises by 1 / (1 - rounding) and the fines take no mass, only what the
/// shift of the centres of mass and the larger inertia leave over of momentum and energy.
void split_grain(Grains& grains, std::size_t i, int axis, const FractureModel& fracture, Fines& fines);

}  // namespace grus::dem
