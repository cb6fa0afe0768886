// SPDX-License-Identifier: LGPL-3.0-or-later
// Eigen's decompositions are slow to compile: here once, for all.
#include "dem/base/tensor.hpp"

namespace grus::dem {

/// Newton's iteration x <- (x + x^-T) / 2 ends at the rotation, the error squared in each round (Higham, SIAM J. Sci.
/// Stat. Comput. 7, 1986): two rounds for an increment, where singular values take ten times as long.
void polar(const Mat3& f, Mat3& r, Mat3& u) {
  Mat3 x = f;
  for (int round = 0; round < 8; ++round) {
    const Mat3 change = 0.5 * (x.inverse().transpose() - x);
    x += change;
    if (const double left = change.squaredNorm(); left < 1e-16) {  // what is still to come is its half, round-off
      r = x;
      u = r.transpose() * f;
      u = 0.5 * (u + u.transpose().eval());
      return;
    }
  }
  const Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  r = svd.matrixU() * svd.matrixV().transpose();
  u = svd.matrixV() * svd.singularValues().asDiagonal() * svd.matrixV().transpose();
}

PrincipalAxes principal_axes(const Mat3& symmetric) {
  Eigen::SelfAdjointEigenSolver<Mat3> eigen;
  eigen.computeDirect(symmetric);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

Vec3 principal_values(const Mat3& symmetric) {
  Eigen::SelfAdjointEigenSolver<Mat3> eigen;
  eigen.computeDirect(symmetric, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues();
}

Mat6 turned(const Mat6& tangent, const Mat3& r) {
  Mat6 q;
  for (int k = 0; k < 6; ++k) q.col(k) = to_voigt(r * from_voigt(Vec6::Unit(k)) * r.transpose());
  return q * tangent * q.transpose();
}

}  // namespace grus::dem
