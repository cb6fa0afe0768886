// SPDX-License-Identifier: LGPL-3.0-or-later
// Halves of a poly-ellipsoid (Zhang et al. 2015, 3.3.2): each keeps exactly 1 - rounding of its half's volume, lies
// inside the parent, keeps the parent's outer tip with its curvature, and touches its sibling in the parent's origin.
#pragma once

#include <array>

#include "dem/fracture/splitter.hpp"

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

/// Whether the shape allows any axis (break_plane.hpp).
bool can_split(const Halves& splitter, const Grains& grains, std::size_t i);

/// The + half first. With the density unchanged (1 - rounding) of the mass stays, with `keep_mass` it rises by
/// 1 / (1 - rounding) and no mass is lost.
Pieces pieces_of(const Halves& splitter, const Grains& grains, std::size_t i, const Wanted& wanted, std::uint64_t seed);

/// The same along a given axis, the parent's geometry frame turned to `orientation`.
Pieces halves_of(const Halves& splitter, const Grains& grains, std::size_t i, int axis, const Quat& orientation);

}  // namespace grus::dem
