// SPDX-License-Identifier: LGPL-3.0-or-later
// What a tangent says of a deformation.
#pragma once

#include "dem/base/tensor.hpp"

namespace grus::coupling {

/// Strain (Voigt, engineering shear) between two deformations, to first order.
inline dem::Vec6 strain_between(const dem::Mat3& from, const dem::Mat3& to) {
  dem::Vec6 strain = dem::to_voigt(to - from);
  strain.tail<3>() *= 2;
  return strain;
}

/// Stress after a deformation F = R U by a tangent: R (stress + C : (U - 1)) R^T.
inline dem::Mat3 predicted(const dem::Mat3& stress, const dem::Mat6& tangent, const dem::Mat3& deformation) {
  dem::Mat3 r, u;
  dem::polar(deformation, r, u);
  return r * (stress + dem::from_voigt(tangent * strain_between(dem::Mat3::Identity(), u))) * r.transpose();
}

}  // namespace grus::coupling
