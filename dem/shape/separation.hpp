// SPDX-License-Identifier: LGPL-3.0-or-later
// How far two convex hulls are apart, and along what (Gilbert, Johnson & Keerthi, IEEE J. Robotics and Automation 4
// (1988) 193). Poses as in overlap.hpp: B's is x = turn * x_b + shift, everything in the frame of A.
#pragma once

#include "dem/shape/hull_store.hpp"

namespace grus::dem {

/// Distance (m); 0 or less where the hulls meet. `direction`: where to begin, if it is not zero; then the unit vector
/// from A to B along which they are parted by that distance, edges against edges too, as it was where they meet.
double separation(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, Vec3& direction);

/// Separation along a direction from A to B (m).
double separation_along(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, const Vec3& n);

/// Largest separation along one of the hulls' face normals or the centres' line (m): negative where none parts them.
/// `direction`: its direction, from A to B.
double face_separation(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, Vec3& direction);

}  // namespace grus::dem
