// SPDX-License-Identifier: LGPL-3.0-or-later
// Eigen's decompositions are slow to compile: here once, for all.
#include "dem/base/tensor.hpp"

namespace grus::dem {

void polar(const Mat3& f, Mat3& r, Mat3& u) {
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
