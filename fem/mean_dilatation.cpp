// SPDX-License-Identifier: LGPL-3.0-or-later
// Elements with mean dilatation. F stretched to the element's mean J: s F, s = (mean J / J)^(1/m), in m directions;
// what its virtual work gives, so that the work of nodal forces is that of the stresses, exactly (Nagtegaal, Parks,
// Rice 1974; Moran, Ortiz, Shih 1990).
#include "fem/problem_impl.hpp"

namespace grus::fem {
namespace {

using Matrix3 = Eigen::Matrix3d;
using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

}  // namespace

Matrix3 Problem::Impl::told(const std::vector<double>& from, const std::vector<double>& by, std::size_t point) const {
  Matrix3 f = Eigen::Map<const RowMatrix3>(from.data() + 9 * point);
  if (!by.empty()) f.topRows(stretched()) *= by[point];
  return f;
}

void Problem::Impl::mean_dilatation(const std::vector<double>& from, std::vector<double>& by) const {
  by.resize(size());
  for (std::int32_t c = 0; c < cells; ++c) {
    double volume = 0, now = 0;
    auto J = [&](int q) { return Eigen::Map<const RowMatrix3>(from.data() + 9 * point(c, q)).determinant(); };
    for (int q = 0; q < nq; ++q) volume += local(c, q).dv, now += local(c, q).dv * J(q);
    for (int q = 0; q < nq; ++q) by[point(c, q)] = std::pow(now / volume / J(q), 1.0 / stretched());
  }
}

void Problem::Impl::present(std::int32_t cell, int q, Present& out) const {
  const Local& l = local(cell, q);
  const Eigen::Map<const RowMatrix3> f(F.data() + 9 * point(cell, q));
  out.gradient = l.gradient;
  out.hoop = l.hoop;
  out.volume = l.dv;
  if (discretisation.finite_strain)
    out.gradient = l.gradient * f.inverse(), out.hoop /= f(2, 2), out.volume *= f.determinant();
  out.trace.resize(nodes * components);
  for (int a = 0; a < nodes; ++a)
    for (int k = 0; k < components; ++k)
      out.trace[components * a + k] = out.gradient(a, k) + (k == 0 ? out.hoop[a] : 0);
}

Eigen::VectorXd Problem::Impl::mean_trace(std::int32_t cell, std::vector<Present>& all) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(nodes * components);
  double volume = 0;
  all.resize(static_cast<std::size_t>(nq));
  for (int q = 0; q < nq; ++q) {
    Present& now = all[static_cast<std::size_t>(q)];
    present(cell, q, now);
    sum += now.volume * now.trace, volume += now.volume;
  }
  return sum / volume;
}

/// What the mean dilatation adds to the stiffness beside its part in B (cell_tangent): the change of its virtual work
/// with the displacement.
void Problem::Impl::add_mean_dilatation(std::int32_t cell, const std::vector<Present>& all, const Eigen::VectorXd& mean,
                                        Matrix& k) const {
  const int m = stretched();
  auto transposed = [&](double factor, const Present& now, Matrix& to) {  // factor tr(grad du . grad Du)
    for (int a = 0; a < nodes; ++a)
      for (int e = 0; e < nodes; ++e) {
        for (int i = 0; i < components; ++i)
          for (int j = 0; j < components; ++j)
            to(components * a + i, components * e + j) += factor * now.gradient(a, j) * now.gradient(e, i);
        to(components * a, components * e) += factor * now.hoop[a] * now.hoop[e];
      }
  };
  double volume = 0, pressure = 0;  // m^3; sum of volume x mean stress (J)
  Matrix second = Matrix::Zero(k.rows(), k.cols());
  for (int q = 0; q < nq; ++q) {
    const Present& now = all[static_cast<std::size_t>(q)];
    const std::size_t p = point(cell, q);
    const double* s = stress.data() + 6 * p;
    const double mean_stress = (m == 2 ? s[0] + s[1] : s[0] + s[1] + s[2]) / m,
                 dv = local(cell, q).dv * told(F, stretch, p).determinant();
    const Eigen::VectorXd b = (mean - now.trace) / m;
    Eigen::VectorXd w = Eigen::VectorXd::Zero(k.rows());  // stress : velocity gradient
    for (int a = 0; a < nodes; ++a) {
      const Eigen::Vector3d force = symmetric(s) * now.gradient.row(a).transpose();
      for (int i = 0; i < components; ++i) w[components * a + i] = force[i];
      w[components * a] += s[2] * now.hoop[a];
    }
    k.noalias() += 2 * dv * (b * w.transpose() + w * b.transpose() + m * mean_stress * b * b.transpose());
    transposed(dv * mean_stress, now, k);
    second.noalias() += now.volume * now.trace * now.trace.transpose();
    transposed(-now.volume, now, second);
    volume += now.volume, pressure += dv * mean_stress;
  }
  k += pressure * (second / volume - mean * mean.transpose());
}

}  // namespace grus::fem
