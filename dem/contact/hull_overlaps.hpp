// SPDX-License-Identifier: LGPL-3.0-or-later
// The overlap of two hulls by the kernel for it, and by their faces where round-off decides which edges cross.
#pragma once

#include "dem/kernel/hull_overlap.hpp"
#include "dem/shape/overlap.hpp"

namespace grus::dem {

/// As overlap_by_faces. `search`: a unit vector from A to B, as good as is known; it decides what is looked at, not
/// what is found.
Overlap overlap_of(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, const Vec3& search);

/// What the kernel takes.
HullColumns columns_of(const HullView& hull);
HullPose pose_of(const Mat3& turn, const Vec3& shift, const Vec3& search);

}  // namespace grus::dem
