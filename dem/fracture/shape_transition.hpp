// SPDX-License-Identifier: LGPL-3.0-or-later
// Badly shaped fragments grow back to a breakable shape (Zhang et al. 2015, 3.3.4). The paper moves the octant origin
// and keeps the tips: the surface jumps out of the parent, the forces with it, and the run explodes. Here the centre of
// mass stays (mass, momentum and angular momentum are exact, the tips give way), and the surface grows at a bounded
// rate.
#pragma once

#include <optional>

#include "dem/fracture/fracture_model.hpp"
#include "dem/shape/polyellipsoid.hpp"

namespace grus::dem {

/// The shape after a time `duration` of transition; none where every axis has reached the ratio. Widths, and with them
/// the volume, stay; the longer semi-axis gives to the shorter one. Both surfaces are to be seen from the centre of
/// mass.
std::optional<PolyEllipsoid> next_shape(const PolyEllipsoid& shape, const ShapeTransition& transition, double duration);

/// Growth (m) of the surface along the unit direction d (geometry frame), both bodies seen from their centre of mass.
inline double growth(const PolyEllipsoid& before, const PolyEllipsoid& after, const Vec3& d) {
  return support_height(after, d) - d.dot(centre_of_mass(after)) - support_height(before, d) +
         d.dot(centre_of_mass(before));
}

}  // namespace grus::dem
