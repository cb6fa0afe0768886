// SPDX-License-Identifier: LGPL-3.0-or-later
// Overlap and contact normal of two poly-ellipsoids: the direction of least overlap,
//   overlap = min over unit n of f(n) = h_A(n) + h_B(-n) - n.r,   r from the octant origin of A to that of B,
// by Newton on the sphere from a cached direction. f(n) < 0 for any n proves separation.
#pragma once

#include "dem/shape/polyellipsoid.hpp"

namespace grus::dem {

/// A pair as seen from the geometry frame of A.
struct ShapePair {
  const PolyEllipsoid &a, &b;
  Mat3 b_to_a;
  Vec3 r;
};

struct CommonNormal {
  Vec3 normal;            // unit, from A to B
  double overlap;         // m; negative: the gap (exact where the search converged)
  Vec3 point_a, point_b;  // support points, from the octant origin of A
  bool converged;
};

/// f(n) alone.
double separation_test(const ShapePair& pair, const Vec3& n);

/// From a cached normal, at most a few Newton steps; line search where they fail. Stops as soon as f < 0 proves
/// separation: the overlap is then negative, but not the exact gap.
CommonNormal warm_common_normal(const ShapePair& pair, const Vec3& n0);

/// From nothing; checks for deeper pairs that the minimum is the lowest of many starts.
CommonNormal cold_common_normal(const ShapePair& pair);

/// Local curvature at the contact: effective radius sqrt(R'R'') of the relative-curvature ellipse (m), and the factor
/// by which an elliptic Hertz contact exceeds the circular one of that radius (0.4 % up to 1000:1).
struct ContactCurvature {
  double radius, ellipse_factor;
};
ContactCurvature contact_curvature(const ShapePair& pair, const Vec3& n);

/// The same against a plane whose outward direction from the body is `d` (geometry frame).
ContactCurvature plane_curvature(const PolyEllipsoid& shape, const Vec3& d);

}  // namespace grus::dem
