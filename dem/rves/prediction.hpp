// SPDX-License-Identifier: LGPL-3.0-or-later
// Predictions of a tangent for a deformation.
#pragma once

#include "dem/base/tensor.hpp"

namespace grus::dem {

/// Strain (Voigt, engineering shear) between two deformations, to first order.
inline Vec6 strain_between(const Mat3& from, const Mat3& to) {
  Vec6 strain = to_voigt(to - from);
  strain.tail<3>() *= 2;
  return strain;
}

/// Stress after a deformation F = R U by a tangent: R (stress + C : (U - 1)) R^T.
inline Mat3 predicted(const Mat3& stress, const Mat6& tangent, const Mat3& deformation) {
  Mat3 r, u;
  polar(deformation, r, u);
  return r * (stress + from_voigt(tangent * strain_between(Mat3::Identity(), u))) * r.transpose();
}

}  // namespace grus::dem
