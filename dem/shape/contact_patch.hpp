// SPDX-License-Identifier: LGPL-3.0-or-later
// How the surface of a hull within another body resists turns.
#pragma once

#include <span>

#include "dem/shape/hull_store.hpp"

namespace grus::dem {

/// Integral of |x - middle|^2 1 - (x - middle)(x - middle)^T over A's surface within the planes (normal . x <= offset),
/// all in the frame of A (m^4): what a foundation of modulus 1 on it does against turns about the middle, by axis.
Mat3 turning_of_patch(const HullView& a, std::span<const Plane> planes, const Vec3& middle);

}  // namespace grus::dem
