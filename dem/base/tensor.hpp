// SPDX-License-Identifier: LGPL-3.0-or-later
// Vectors and tensors. Tension-positive; Voigt order xx yy zz yz xz xy, engineering shear in strains.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <cstdint>

namespace grus::dem {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Index = std::uint32_t;

inline constexpr double pi = 3.14159265358979323846;
inline constexpr int voigt_row[6] = {0, 1, 2, 1, 0, 0};
inline constexpr int voigt_col[6] = {0, 1, 2, 2, 2, 1};

/// Symmetric part of a tensor in Voigt order (stress convention: no factor on shear).
inline Vec6 to_voigt(const Mat3& m) {
  Vec6 v;
  for (int i = 0; i < 6; ++i) v[i] = 0.5 * (m(voigt_row[i], voigt_col[i]) + m(voigt_col[i], voigt_row[i]));
  return v;
}

/// Symmetric tensor from Voigt order (stress convention).
inline Mat3 from_voigt(const Vec6& v) {
  Mat3 m;
  for (int i = 0; i < 6; ++i) m(voigt_row[i], voigt_col[i]) = m(voigt_col[i], voigt_row[i]) = v[i];
  return m;
}

/// Rotation by the vector `a` (axis times angle, rad); series below 0.01 rad, exact to round-off.
inline Quat rotation_by(const Vec3& a) {
  const double half2 = 0.25 * a.squaredNorm();
  double c, s;  // cos(half), sin(half)/(2 half)
  if (half2 < 1e-4) {
    c = 1 - half2 * (0.5 - half2 * (1.0 / 24 - half2 / 720));
    s = 0.5 * (1 - half2 * (1.0 / 6 - half2 * (1.0 / 120 - half2 / 5040)));
  } else {
    const double half = std::sqrt(half2);
    c = std::cos(half);
    s = 0.5 * std::sin(half) / half;
  }
  return Quat(c, s * a.x(), s * a.y(), s * a.z());
}

/// Turns `q` back to unit length; the deviation is round-off, so one Newton step suffices.
inline Quat unit(const Quat& q) {
  const double f = 1.5 - 0.5 * q.squaredNorm();
  return Quat(q.w() * f, q.x() * f, q.y() * f, q.z() * f);
}

/// Matrix of the cross product: cross_matrix(a) b = a x b.
inline Mat3 cross_matrix(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// F = R U, R a rotation, U symmetric.
void polar(const Mat3& f, Mat3& r, Mat3& u);

/// Principal values of a symmetric tensor, ascending, and their directions, column by column.
struct PrincipalAxes {
  Vec3 values;
  Mat3 directions;
};
PrincipalAxes principal_axes(const Mat3& symmetric);
Vec3 principal_values(const Mat3& symmetric);

/// A tangent (Voigt, engineering shear) in a frame turned by r: Q C Q^T, Q what the turn does to stresses.
Mat6 turned(const Mat6& tangent, const Mat3& r);

/// Mean pressure, compression-positive, of a tension-positive stress.
inline double mean_pressure(const Mat3& stress) { return -stress.trace() / 3; }

}  // namespace grus::dem
