// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/bond/cohesive.hpp"

#include <algorithm>

namespace grus::dem {

Pull pull(CohesiveSpring& s, const BondFrame& at, const FaceOutline&) {
  const Vec3 arm_a = at.a * s.at_a, arm_b = at.b * s.at_b, normal = at.a * s.normal_a;
  Vec3 w = at.x_b + arm_b - at.x_a - arm_a + at.a * s.preload;
  const double opening = w.dot(normal);
  if (opening < 0) w -= opening * normal;  // compression is the contact's
  s.reached = std::max(s.reached, w.norm());
  s.force = -remaining_force(s) / s.reached * w;
  return {s.force, arm_b + at.x_b - at.x_a, arm_b};
}

}  // namespace grus::dem
