// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/polyellipsoid.hpp"

#include <algorithm>

namespace grus::dem {

Mat3 second_moment(const PolyEllipsoid& s) {
  const Vec3 d = s.plus - s.minus;
  Mat3 m = (2 / (5 * pi) - 9.0 / 64) * d * d.transpose();
  for (int k = 0; k < 3; ++k) {
    const double p = s.plus[k], q = s.minus[k];
    m(k, k) = (p * p - p * q + q * q) / 5 - 9.0 / 64 * d[k] * d[k];
  }
  return m;
}

double bounding_radius(const PolyEllipsoid& s) {
  // Octant by octant: |x - c|^2 = |x|^2 - 2 x.c + |c|^2, with |x| at most the longest semi-axis of the octant.
  if (s.is_sphere()) return s.plus.x();
  const Vec3 c = centre_of_mass(s);
  double worst = 0;
  for (int octant = 0; octant < 8; ++octant) {
    Vec3 a, e;  // semi-axes, and the centre of mass as seen from this octant
    for (int k = 0; k < 3; ++k) {
      const bool positive = (octant >> k & 1) == 0;
      a[k] = positive ? s.plus[k] : s.minus[k];
      e[k] = positive ? c[k] : -c[k];
    }
    // 0 <= x_k: x.c is at least minus the support height along the negative parts of c.
    const Vec3 n = e.cwiseMin(0.0);
    const double minus_xc = std::sqrt(n.cwiseProduct(n).dot(a.cwiseProduct(a)));
    worst = std::max(worst, a.maxCoeff() * a.maxCoeff() + 2 * minus_xc + c.squaredNorm());
  }
  return std::sqrt(worst);
}

PrincipalFrame principal_frame(const PolyEllipsoid& s) {
  if (s.is_sphere()) return {Vec3::Constant(0.4 * s.plus.x() * s.plus.x()), Quat::Identity()};
  return principal_frame(second_moment(s));
}

PrincipalFrame principal_frame(const Mat3& m) {
  Vec3 moments;
  Mat3 axes;
  if (m(0, 1) == 0 && m(1, 2) == 0 && m(0, 2) == 0) {  // at most one uneven axis: already principal
    moments = Vec3::Constant(m.trace()) - m.diagonal();
    axes.setIdentity();
  } else {
    Eigen::SelfAdjointEigenSolver<Mat3> solver(m.trace() * Mat3::Identity() - m);
    moments = solver.eigenvalues();
    axes = solver.eigenvectors();
  }
  int last = 0;  // the axis whose removal leaves the closest pair of inverse moments
  double closest = INFINITY;
  for (int k = 0; k < 3; ++k) {
    const double gap = std::abs(1 / moments[(k + 1) % 3] - 1 / moments[(k + 2) % 3]);
    if (gap < closest) closest = gap, last = k;
  }
  Mat3 ordered;
  Vec3 sorted;
  for (int k = 0; k < 3; ++k) {
    ordered.col(k) = axes.col((last + 1 + k) % 3);
    sorted[k] = moments[(last + 1 + k) % 3];
  }
  if (ordered.determinant() < 0) ordered.col(0) = -ordered.col(0);
  return {sorted, Quat(ordered).normalized()};
}

}  // namespace grus::dem
