// SPDX-License-Identifier: LGPL-3.0-or-later
// Which principal plane of a poly-ellipsoid a grain breaks along (Zhang et al. 2015, 3.3 and 3.3.3, cases 1-5).
#pragma once

#include <optional>

#include "dem/base/random.hpp"
#include "dem/shape/polyellipsoid.hpp"

namespace grus::dem {

/// Preference of each axis as normal of the break plane; the largest allowed one wins.
/// Hoek-Brown: normal stress along the axis (tension-positive); contact tension: |axis . normal of the critical plane|.
using AxisPreference = Vec3;

/// Axis (0, 1, 2) along which the grain is split, or none where its shape forbids it: an axis is bad when its shorter
/// semi-axis is below 0.2 of the longer one; a body is also split across a bad pair only if it is 1.2 times longer.
std::optional<int> choose_axis(const PolyEllipsoid& shape, const AxisPreference& preference);

/// Orientation of a sphere's geometry frame with `axis` turned the shortest way onto the line of `normal` (global).
Quat turned_to_plane(const Quat& orientation, int axis, const Vec3& normal);

/// The slight rotation of eqs 19-23: columns are the turned axes in the old frame; each angle is drawn from
/// [-theta, -theta/2] and [theta/2, theta], keyed by (seed, id).
Mat3 slight_rotation(double theta, std::uint64_t seed, std::uint64_t id);

}  // namespace grus::dem
