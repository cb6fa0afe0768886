// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/shape_transition.hpp"

#include <algorithm>

namespace grus::dem {

std::optional<PolyEllipsoid> next_shape(const PolyEllipsoid& shape, const ShapeTransition& t, double duration) {
  PolyEllipsoid next = shape;
  bool changed = false;
  for (int k = 0; k < 3; ++k) {
    double& low = shape.plus[k] < shape.minus[k] ? next.plus[k] : next.minus[k];
    double& high = shape.plus[k] < shape.minus[k] ? next.minus[k] : next.plus[k];
    const double width = low + high, target = width * t.ratio / (1 + t.ratio);
    if (low >= target * (1 - 1e-9)) continue;
    low = std::min(target, low + target * duration / t.time);
    high = width - low;
    changed = true;
  }
  return changed ? std::optional(next) : std::nullopt;
}

}  // namespace grus::dem
