// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/average_elements.hpp"

#include <algorithm>
#include <cmath>

namespace grus::fem {
namespace {

std::vector<TensorColumn> tensor_columns(Kinematics kinematics) {
  const TensorColumn xx{{1, 0, 0, 0, 0, 0}}, yy{{0, 1, 0, 0, 0, 0}}, zz{{0, 0, 1, 0, 0, 0}}, yz{{0, 0, 0, 1, 0, 0}},
      xz{{0, 0, 0, 0, 1, 0}}, xy{{0, 0, 0, 0, 0, 1}};
  if (kinematics == Kinematics::solid) return {xx, yy, zz, yz, xz, xy};
  if (kinematics == Kinematics::plane_strain) return {xx, yy, zz, xy};
  return {{{1, 0, 1, 0, 0, 0}, 0, 0.5}, yy, {{1, 0, -1, 0, 0, 0}, 4, 0.5}, {{0, 0, 0, 0, 0, 1}, 1}};
}

}  // namespace

AverageElements::AverageElements(Problem& problem, const std::vector<std::size_t>& which)
    : p(problem.impl()),
      points(which),
      columns(tensor_columns(p.discretisation.kinematics)),
      corners(p.geometry_nodes) {
  const auto nq = static_cast<std::size_t>(p.nq);
  for (const std::size_t i : points) {
    const std::size_t q = i % nq;
    const auto dofs = compat::geometry_dofs(*p.mesh, static_cast<std::int32_t>(i / nq));
    for (int a = 0; a < corners; ++a) {
      nodes.push_back(dofs[static_cast<std::size_t>(a)]);
      shares.push_back(p.geometry_basis[q * static_cast<std::size_t>(corners) + static_cast<std::size_t>(a)]);
    }
    volumes.push_back(p.locals[i].dv);
  }
}

/// Fewer points than corners cannot tell these from each other: the mass is then dealt to them.
AverageElements::Element AverageElements::element(std::size_t first, std::size_t end, double length) const {
  Element e{Matrix::Zero(corners, corners), Matrix::Zero(corners, corners)};
  const int nq = p.nq;
  for (std::size_t k = first; k < end; ++k) {
    const auto& l = p.locals[points[k]];
    const int q = static_cast<int>(points[k] % static_cast<std::size_t>(nq));
    const Eigen::Map<const Eigen::VectorXd> share(shares.data() + k * static_cast<std::size_t>(corners), corners);
    const Eigen::Matrix3d back = l.jacobian.inverse();
    Eigen::Matrix<double, Eigen::Dynamic, 3> gradient(corners, 3);
    for (int a = 0; a < corners; ++a) {
      Eigen::RowVector3d d = Eigen::RowVector3d::Zero();
      for (int j = 0; j < p.dim; ++j)
        d[j] = p.geometry_basis[static_cast<std::size_t>(((j + 1) * nq + q) * corners + a)];
      gradient.row(a) = d * back;
    }
    const double stiffness = l.dv * length * length;
    if (end - first >= static_cast<std::size_t>(corners))
      e.plain += l.dv * share * share.transpose();
    else
      e.plain.diagonal() += l.dv * share;
    e.plain += stiffness * gradient * gradient.transpose();
    if (p.discretisation.kinematics == Kinematics::axisymmetric)
      e.turning += stiffness / (l.at[0] * l.at[0]) * share * share.transpose();
  }
  return e;
}

void AverageElements::widen(std::array<double, 2>& bounds, const Element& e) const {
  for (const TensorColumn& column : columns) {
    Matrix m = e.sum(column.turns);
    const Eigen::VectorXd scale = m.diagonal().cwiseSqrt().cwiseInverse();
    m = scale.asDiagonal() * m * scale.asDiagonal();
    const Eigen::VectorXd all = Eigen::SelfAdjointEigenSolver<Matrix>(m, Eigen::EigenvaluesOnly).eigenvalues();
    bounds[0] = std::min(bounds[0], all.minCoeff()), bounds[1] = std::max(bounds[1], all.maxCoeff());
  }
}

ChebyshevSteps::ChebyshevSteps(const std::array<double, 2>& bounds, double promised, int most)
    : degree(0), middle(0.5 * (bounds[1] + bounds[0])), half(0.5 * (bounds[1] - bounds[0])) {
  const auto [low, high] = bounds;
  if (!(high > 0)) return;  // no point on any rank
  const double stretch = low > 0 ? (high + low) / std::max(high - low, 1e-9 * high) : 1;
  const double wanted = std::acosh(1 / promised) / std::acosh(stretch);
  if (!(wanted <= most))
    throw std::invalid_argument("the length is too long for the smallest elements to be averaged over");
  degree = static_cast<int>(std::ceil(wanted));
}

}  // namespace grus::fem
