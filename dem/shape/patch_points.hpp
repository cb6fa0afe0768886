// SPDX-License-Identifier: LGPL-3.0-or-later
// The points at which hulls that lie on each other may press: corners of the patch that they share.
#pragma once

#include <array>

#include "dem/shape/hull_store.hpp"

namespace grus::dem {

struct PatchPoint {
  Vec3 at;     // half-way between the surfaces, in the frame of A (m)
  double gap;  // along the normal, negative where they are in each other (m)
};

/// Of a patch with more corners those are taken that lie furthest apart.
inline constexpr std::size_t most_patch_points = 8;

struct Patch {
  std::array<PatchPoint, most_patch_points> point;
  std::size_t points = 0;
};

/// Corners at which the faces that meet along `n` (unit, from A to B, in the frame of A) are no further apart along it
/// than `reach`: the nearest first. B's pose is x = turn * x_b + shift. Of edges that cross, and corners, one point.
Patch patch_between(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, const Vec3& n,
                    double reach);

/// The same of a half space normal . x <= offset, in the frame of A, which takes the place of B.
Patch patch_on_plane(const HullView& a, const Plane& wall, double reach);

}  // namespace grus::dem
