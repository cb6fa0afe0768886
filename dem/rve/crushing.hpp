// SPDX-License-Identifier: LGPL-3.0-or-later
// Measures of a sample that loses fines to its voids and presses its fragments deep into one another.
#pragma once

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// Solid of grains and fines at the densities of their materials (m^3): what is left of it when grains are replaced by
/// lighter or smaller ones is in the fines, or in their density.
double whole_solid(const Model& model, const State& state);

/// K0 and its like: mean of the two lateral stresses over that along the axis; NaN without it.
double lateral_ratio(const Vec3& stresses, int axis);

/// The share of touching contacts whose overlap is beyond this part of the smaller equivalent radius.
double share_deeper(const State& state, double part);

}  // namespace grus::dem
