// SPDX-License-Identifier: LGPL-3.0-or-later
// Strain that gauges on the middle of a sample between platens read, away from its ends.
#pragma once

#include "dem/rve/measure.hpp"

namespace grus::dem {

/// Displacement gradient of the middle half of the height between two platens: the affine motion that the centres of
/// the grains that began there follow best, weighted by their masses. Grains that have broken are left out. NaN along
/// an axis along which the centres do not differ (a mesh of one layer), and everywhere where grains are too few.
Mat3 gauged_gradient(const State& first, const State& now, int axis);

}  // namespace grus::dem
