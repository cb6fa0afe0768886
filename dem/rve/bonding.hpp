// SPDX-License-Identifier: LGPL-3.0-or-later
// Cohesive springs between the halves of a fresh split: they start with the forces that let both go on as their parent.
#pragma once

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// The parent's rigid motion: what the children should go on with.
struct ParentMotion {
  Vec3 position, acceleration, spin, spin_rate, origin;
  Mat3 axes;
  PolyEllipsoid shape;
};

ParentMotion motion_of(const Grains& grains, std::size_t i);

/// Springs across the plane normal to `axis`, between the halves in slots `plus` and `minus` (Zhang et al.
/// 2015, 3.4.2-3.4.3): the six equations of both halves' acceleration over the springs, least norm; what they cannot
/// carry is booked.
void add_springs(const Model& model, State& state, const ParentMotion& parent, int axis, std::size_t plus,
                 std::size_t minus);

}  // namespace grus::dem
