// SPDX-License-Identifier: LGPL-3.0-or-later
// Cohesive springs between the halves of a fresh split: they start with the forces that let both go on as their parent.
#pragma once

#include <span>

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// The parent's rigid motion: what the children should go on with.
struct ParentMotion {
  Vec3 position, acceleration, spin, spin_rate, origin;
  Mat3 axes;
  double radius;  // of the sphere of equal volume (m)
};

ParentMotion motion_of(const Grains& grains, std::size_t i);

/// Springs across a plane between two of the pieces in `slots` (Zhang et al. 2015, 3.4.2-3.4.3): the six equations of
/// both pieces' acceleration over the springs, least norm; what they cannot carry is booked.
/// Returns what they hold at birth (J).
double add_springs(const Model& model, State& state, const ParentMotion& parent, const FreshPlane& plane,
                   std::span<const std::size_t> slots);

}  // namespace grus::dem
