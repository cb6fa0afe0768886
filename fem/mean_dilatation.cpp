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

void Problem::Impl::mean_dilatation(const std::vector<double>& J, std::vector<double>& by) const {
  by.resize(size());
  for (std::int32_t c = 0; c < cells; ++c) {
    double volume = 0, now = 0;
    const double* const at = J.data() + point(c, 0);
    for (int q = 0; q < nq; ++q) volume += local(c, q).dv, now += local(c, q).dv * at[q];
    for (int q = 0; q < nq; ++q) by[point(c, q)] = std::pow(now / volume / at[q], 1.0 / stretched());
  }
}

void Problem::Impl::present(std::int32_t cell, int q, Present& out) const {
  const Local& l = local(cell, q);
  const Matrix3 f = Eigen::Map<const RowMatrix3>(F.data() + 9 * point(cell, q));
  const bool finite = discretisation.finite_strain, turned = discretisation.kinematics == Kinematics::axisymmetric;
  const RowMatrix3 inverse = finite ? RowMatrix3(f.inverse()) : RowMatrix3(RowMatrix3::Identity());
  out.volume = finite ? l.dv * f.determinant() : l.dv;
  out.gradient.resize(nodes, 3), out.hoop.resize(nodes), out.trace.resize(nodes * components);
  const double* from = l.gradient.data();
  double* to = out.gradient.data();
  for (int a = 0; a < nodes; ++a, from += 3, to += 3) {
    for (int k = 0; k < 3; ++k) to[k] = from[0] * inverse(0, k) + from[1] * inverse(1, k) + from[2] * inverse(2, k);
    out.hoop[a] = turned ? l.hoop[a] / (finite ? f(2, 2) : 1) : 0;
    for (int k = 0; k < components; ++k) out.trace[components * a + k] = to[k] + (k == 0 ? out.hoop[a] : 0);
  }
}

void Problem::Impl::mean_trace(std::int32_t cell, std::vector<Present>& all, Eigen::VectorXd& mean) const {
  mean.setZero(nodes * components);
  double volume = 0;
  all.resize(static_cast<std::size_t>(nq));
  for (int q = 0; q < nq; ++q) {
    Present& now = all[static_cast<std::size_t>(q)];
    present(cell, q, now);
    mean += now.volume * now.trace, volume += now.volume;
  }
  mean /= volume;
}

/// What the mean dilatation adds to the stiffness beside its part in B (cell_tangent): the change of its virtual work
/// with the displacement.
void Problem::Impl::add_mean_dilatation(std::int32_t cell, const std::vector<Present>& all, const Eigen::VectorXd& mean,
                                        Matrix& k) const {
  const int m = stretched(), width = components, rows = nodes * components;
  double volume = 0, pressure = 0;  // m^3; sum of volume x mean stress (J)
  const auto mean_stress = [&](std::size_t p) {
    const double* s = stress.data() + 6 * p;
    return (m == 2 ? s[0] + s[1] : s[0] + s[1] + s[2]) / m;
  };
  const auto stretched_volume = [&](int q) {
    return local(cell, q).dv * told(F, stretch, point(cell, q)).determinant();
  };
  for (int q = 0; q < nq; ++q)
    volume += all[static_cast<std::size_t>(q)].volume, pressure += stretched_volume(q) * mean_stress(point(cell, q));
  Eigen::VectorXd b(rows), w(rows);
  for (int q = 0; q < nq; ++q) {
    const Present& now = all[static_cast<std::size_t>(q)];
    const std::size_t p = point(cell, q);
    const Matrix3 sigma = symmetric(stress.data() + 6 * p);
    const double dv = stretched_volume(q), even = mean_stress(p), share = pressure * now.volume / volume;
    b = (mean - now.trace) / m;
    for (int a = 0; a < nodes; ++a) {  // stress : velocity gradient
      const Eigen::Vector3d force = sigma * now.gradient.row(a).transpose();
      for (int i = 0; i < width; ++i) w[width * a + i] = force[i];
      w[width * a] += sigma(2, 2) * now.hoop[a];
    }
    // 2 dv (b w + w b + m even b b), the share's part of the trace of traces, and of tr(grad du . grad Du) the rest.
    w += 0.5 * m * even * b;
    const double rest = dv * even - share;
    const double *at_b = b.data(), *at_w = w.data(), *trace = now.trace.data(), *g = now.gradient.data();
    for (int a = 0; a < nodes; ++a)
      for (int i = 0; i < width; ++i) {
        const int row = width * a + i;
        double* __restrict to = k.data() + row * rows;
        const double of_b = 2 * dv * at_w[row], of_w = 2 * dv * at_b[row], of_trace = share * trace[row];
        for (int e = 0; e < rows; ++e) to[e] += of_b * at_b[e] + of_w * at_w[e] + of_trace * trace[e];
        for (int e = 0; e < nodes; ++e) {
          const double along = rest * g[3 * e + i];
          for (int j = 0; j < width; ++j) to[width * e + j] += along * g[3 * a + j];
          if (i == 0) to[width * e] += rest * now.hoop[a] * now.hoop[e];
        }
      }
  }
  const double* const means = mean.data();
  for (int row = 0; row < rows; ++row) {
    double* __restrict to = k.data() + row * rows;
    for (int e = 0; e < rows; ++e) to[e] -= pressure * means[row] * means[e];
  }
}

}  // namespace grus::fem
