// SPDX-License-Identifier: LGPL-3.0-or-later
// The poly-ellipsoid: eight octants of ellipsoids that share six semi-axes (Peters et al. 2009; Zhang et al. 2015, eq
// 2). Geometry frame: origin where the octants meet, axes along the semi-axes. A sphere has six equal semi-axes.
#pragma once

#include "dem/base/tensor.hpp"

namespace grus::dem {

/// Six semi-axes (m): plus[k] along +k, minus[k] along -k.
struct PolyEllipsoid {
  Vec3 plus = Vec3::Zero(), minus = Vec3::Zero();

  static PolyEllipsoid sphere(double radius) { return {Vec3::Constant(radius), Vec3::Constant(radius)}; }
  bool is_sphere() const { return plus == minus && plus.x() == plus.y() && plus.y() == plus.z(); }
};

/// Squared semi-axis of each direction that the octant of `d` uses.
inline Vec3 octant_squares(const PolyEllipsoid& s, const Vec3& d) {
  const double a = d.x() >= 0 ? s.plus.x() : s.minus.x();
  const double b = d.y() >= 0 ? s.plus.y() : s.minus.y();
  const double c = d.z() >= 0 ? s.plus.z() : s.minus.z();
  return {a * a, b * b, c * c};
}

/// Support height h(d) = max over the body of d.x, from the octant origin; d need not be unit (m times |d|).
inline double support_height(const PolyEllipsoid& s, const Vec3& d) {
  return std::sqrt(octant_squares(s, d).dot(d.cwiseProduct(d)));
}

/// Furthest point along d, from the octant origin (m).
inline Vec3 support(const PolyEllipsoid& s, const Vec3& d) {
  const Vec3 p = octant_squares(s, d).cwiseProduct(d);
  return p / std::sqrt(p.dot(d));
}

/// Sum of the two principal radii of the surface where its normal is the unit vector d (m).
inline double sum_of_radii(const PolyEllipsoid& s, const Vec3& d) {
  const Vec3 squares = octant_squares(s, d), p = squares.cwiseProduct(d);
  const double q2 = p.dot(d);
  return (squares.sum() - p.squaredNorm() / q2) / std::sqrt(q2);
}

inline double volume(const PolyEllipsoid& s) {
  const Vec3 w = s.plus + s.minus;
  return pi / 6 * w.x() * w.y() * w.z();
}

/// Centre of mass from the octant origin: 3/8 (a+ - a-) along each axis.
inline Vec3 centre_of_mass(const PolyEllipsoid& s) { return 0.375 * (s.plus - s.minus); }

/// Mean of (x - c)(x - c)^T over the body, c the centre of mass (m^2); products do not vanish when two axes are uneven.
Mat3 second_moment(const PolyEllipsoid& s);

/// Radius of the sphere of equal volume.
inline double equivalent_radius(const PolyEllipsoid& s) { return std::cbrt(0.75 / pi * volume(s)); }

/// Largest distance of a surface point from the centre of mass, bounded from above.
double bounding_radius(const PolyEllipsoid& s);

inline double smallest_semi_axis(const PolyEllipsoid& s) { return std::min(s.plus.minCoeff(), s.minus.minCoeff()); }

/// Principal frame of the inertia: `moments` per unit mass (m^2), `axes` principal -> geometry. The axes are ordered
/// so that the first two have the closest inverse moments (what symmetric-top splitting wants).
struct PrincipalFrame {
  Vec3 moments;
  Quat axes;
};
PrincipalFrame principal_frame(const PolyEllipsoid& s);
/// The same of any body with mean (x - c)(x - c)^T of `second` (m^2).
PrincipalFrame principal_frame(const Mat3& second);

}  // namespace grus::dem
