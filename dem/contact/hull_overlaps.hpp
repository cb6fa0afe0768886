// SPDX-License-Identifier: LGPL-3.0-or-later
// The overlap of two hulls by the kernel for it, and by their faces where round-off decides which edges cross.
#pragma once

#include "dem/kernel/hull_overlap.hpp"
#include "dem/shape/overlap.hpp"

namespace grus::dem {

/// As overlap_by_faces, in the global frame about A's origin; `axes_a`, `axes_b`: own frame -> global, `shift`: from
/// A's origin to B's. `search`: a unit vector from A to B, as good as is known; it decides what is looked at, and no
/// bit of what is found. `guess` may be null.
Overlap overlap_of(const HullView& a, const HullView& b, const Mat3& axes_a, const Mat3& axes_b, const Vec3& shift,
                   const Vec3& search, HullGuess* guess = nullptr);
inline Overlap overlap_of(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift,
                          const Vec3& search) {
  return overlap_of(a, b, Mat3::Identity(), turn, shift, search);
}

/// From the frame of A to the global one.
Overlap turned(const Overlap& o, const Mat3& axes);

/// What the kernel takes; a pose looks at what it is given.
HullColumns columns_of(const HullView& hull);
HullPose pose_of(const Mat3& axes_a, const Mat3& axes_b, const Vec3& shift, const Vec3& search);

}  // namespace grus::dem
