// SPDX-License-Identifier: LGPL-3.0-or-later
// How far any grain may have gone against the affine motion of the cell, from the fastest of each step alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "dem/state/grains.hpp"

namespace grus::dem {

/// Of one run of steps: the affine motion takes along what grains have gone so far, and speeds are told against what
/// that motion was when the run began. No way is longer than this says.
class WayBound {
public:
  /// `affine`: velocity gradient of the cell as the run begins (1/s).
  WayBound(const Grains& g, const Mat3& affine, double dt) : dt_(dt), rate_(affine.norm()) {
    for (std::size_t i = 0; i < g.size() && rate_ > 0; ++i) far_ = std::max(far_, g.motion[i].position.squaredNorm());
    far_ = std::sqrt(far_);
  }
  /// What step `k` of the run adds to `way` (m); `speed` (m/s): the fastest, against the affine motion.
  double of_step(std::uint64_t k, double speed, double way) {
    if (rate_ == 0) return dt_ * speed;
    const double strain = static_cast<double>(k) * dt_ * rate_, now = rate_ / std::max(1 - strain, 0.0);
    const double gone = dt_ * (speed + now * (way + strain * far_));
    far_ += dt_ * (speed + rate_ * far_);
    return gone;
  }

private:
  double dt_, rate_, far_ = 0;  // s; norm of the gradient (1/s); of any grain from the origin (m)
};

}  // namespace grus::dem
