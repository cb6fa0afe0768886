// SPDX-License-Identifier: LGPL-3.0-or-later
// The equation is solved by a Chebyshev polynomial of its matrix over its diagonal, whose spectrum lies between those
// of the elements (Wathen 1987): a fixed number of products, no sum over nodes, the same bits however it is cut.
#include "fem/stretch_average.hpp"

#include <Eigen/Sparse>
#include <array>
#include <cmath>

#include "fem/problem_impl.hpp"

namespace grus::fem {
namespace {

using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor, std::int32_t>;
using Matrix = Problem::Impl::Matrix;
using Fields = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;  // nodes, columns

/// One number of a tensor as a sum of its components, and back; and the multiple of l^2 / r^2 that axial symmetry gives
/// it in Laplace's operator: 4 where it turns with the radius twice (rr less hoop), 1 where once (ry).
struct Column {
  std::array<double, 6> of;  // xx yy zz yz xz xy
  double turns = 0, back = 1;
};

std::vector<Column> columns_of(Kinematics kinematics) {
  const Column xx{{1, 0, 0, 0, 0, 0}}, yy{{0, 1, 0, 0, 0, 0}}, zz{{0, 0, 1, 0, 0, 0}}, yz{{0, 0, 0, 1, 0, 0}},
      xz{{0, 0, 0, 0, 1, 0}}, xy{{0, 0, 0, 0, 0, 1}};
  if (kinematics == Kinematics::solid) return {xx, yy, zz, yz, xz, xy};
  if (kinematics == Kinematics::plane_strain) return {xx, yy, zz, xy};
  return {{{1, 0, 1, 0, 0, 0}, 0, 0.5}, yy, {{1, 0, -1, 0, 0, 0}, 4, 0.5}, {{0, 0, 0, 0, 0, 1}, 1}};
}

/// An element's matrices: mass and l^2 x stiffness, and l^2 x mass / r^2.
struct Element {
  Matrix plain, turning;
  Matrix sum(double turns) const { return plain + turns * turning; }
};

}  // namespace

struct StretchAverage::Impl {
  Problem::Impl& p;
  const std::vector<std::size_t> points;
  const std::vector<Column> columns;
  const int corners;
  std::vector<std::int32_t> nodes;  // of a point's element, `corners` a point
  std::vector<double> shares;       // of the corners at a point: the linear basis
  std::vector<double> volumes;      // of the points, m^3
  std::vector<double> weight;       // of the nodes, m^3
  Sparse plain, turning;            // of one pattern
  Fields inverse;                   // of the diagonal
  double low = INFINITY, high = 0;
  int degree = 0;
  Fields right, mean, residual, change;

  Impl(Problem& problem, const std::vector<std::size_t>& which, double length);
  Element element(std::size_t first, std::size_t end, double length) const;
  void bound(const Element& e);
  void choose_degree();
  void load(std::span<const double> field);
  void solve();
  /// residual = right - matrix x mean
  void find_residual();
  void scale_change(double by, double step);
  double norm(const Fields& of) const { return std::sqrt(of.cwiseProduct(of.cwiseProduct(inverse)).sum()); }
};

StretchAverage::Impl::Impl(Problem& problem, const std::vector<std::size_t>& which, double length)
    : p(problem.impl()), points(which), columns(columns_of(p.discretisation.kinematics)), corners(p.geometry_nodes) {
  int ranks = 1;
  MPI_Comm_size(p.comm, &ranks);
  if (ranks > 1) throw std::invalid_argument("an average over a length needs the mesh on one rank");
  std::vector<std::int32_t> number(p.mesh->geometry().x().size() / 3, -1);
  std::int32_t count = 0;
  const auto nq = static_cast<std::size_t>(p.nq);
  for (const std::size_t i : points) {
    const std::size_t q = i % nq;
    const auto dofs = compat::geometry_dofs(*p.mesh, static_cast<std::int32_t>(i / nq));
    for (int a = 0; a < corners; ++a) {
      std::int32_t& n = number[static_cast<std::size_t>(dofs[static_cast<std::size_t>(a)])];
      if (n < 0) n = count++;
      nodes.push_back(n);
      shares.push_back(p.geometry_basis[q * static_cast<std::size_t>(corners) + static_cast<std::size_t>(a)]);
    }
    volumes.push_back(p.locals[i].dv);
  }
  weight.assign(static_cast<std::size_t>(count), 0);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    weight[static_cast<std::size_t>(nodes[k])] += volumes[k / static_cast<std::size_t>(corners)] * shares[k];
  std::vector<Eigen::Triplet<double, std::int32_t>> of_plain, of_turning;
  for (std::size_t first = 0, end = 0; first < points.size(); first = end) {
    while (end < points.size() && points[end] / nq == points[first] / nq) ++end;
    const Element e = element(first, end, length);
    bound(e);
    const std::int32_t* at = nodes.data() + first * static_cast<std::size_t>(corners);
    for (int a = 0; a < corners; ++a)
      for (int b = 0; b < corners; ++b)
        of_plain.emplace_back(at[a], at[b], e.plain(a, b)), of_turning.emplace_back(at[a], at[b], e.turning(a, b));
  }
  choose_degree();
  plain.resize(count, count), turning.resize(count, count);
  plain.setFromTriplets(of_plain.begin(), of_plain.end());
  turning.setFromTriplets(of_turning.begin(), of_turning.end());
  inverse.resize(count, static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index k = 0; k < inverse.cols(); ++k)
    inverse.col(k) =
        (plain.diagonal() + columns[static_cast<std::size_t>(k)].turns * turning.diagonal()).cwiseInverse();
  right = mean = residual = change = Fields::Zero(count, inverse.cols());
}

/// Of one element, whose points are those from `first` to before `end`. Fewer points than corners cannot tell these
/// from each other: the mass is then dealt to them.
Element StretchAverage::Impl::element(std::size_t first, std::size_t end, double length) const {
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

/// The spectrum of the whole over its diagonal lies within those of the elements.
void StretchAverage::Impl::bound(const Element& e) {
  for (const Column& column : columns) {
    Matrix m = e.sum(column.turns);
    const Eigen::VectorXd scale = m.diagonal().cwiseSqrt().cwiseInverse();
    m = scale.asDiagonal() * m * scale.asDiagonal();
    const Eigen::VectorXd all = Eigen::SelfAdjointEigenSolver<Matrix>(m, Eigen::EigenvaluesOnly).eigenvalues();
    low = std::min(low, all.minCoeff()), high = std::max(high, all.maxCoeff());
  }
}

/// The least whose polynomial is below the promise everywhere between the bounds.
void StretchAverage::Impl::choose_degree() {
  if (points.empty()) return;
  const double stretch = low > 0 ? (high + low) / std::max(high - low, 1e-9 * high) : 1;
  const double wanted = std::acosh(1 / promised) / std::acosh(stretch);
  if (!(wanted <= most_degree))
    throw std::invalid_argument("the length is too long for the smallest elements to be averaged over");
  degree = static_cast<int>(std::ceil(wanted));
}

void StretchAverage::Impl::load(std::span<const double> field) {
  right.setZero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double* t = field.data() + 6 * i;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      double value = 0;
      for (std::size_t k = 0; k < 6; ++k) value += columns[c].of[k] * t[k];
      value *= volumes[i];
      for (std::size_t a = i * static_cast<std::size_t>(corners); a < (i + 1) * static_cast<std::size_t>(corners); ++a)
        right(nodes[a], static_cast<Eigen::Index>(c)) += shares[a] * value;
    }
  }
}

void StretchAverage::Impl::find_residual() {
  for (Eigen::Index row = 0; row < right.rows(); ++row)
    for (Eigen::Index k = 0; k < right.cols(); ++k) {
      const double turns = columns[static_cast<std::size_t>(k)].turns;
      double sum = right(row, k);
      for (auto j = plain.outerIndexPtr()[row]; j < plain.outerIndexPtr()[row + 1]; ++j)
        sum -= (plain.valuePtr()[j] + turns * turning.valuePtr()[j]) * mean(plain.innerIndexPtr()[j], k);
      residual(row, k) = sum;
    }
}

void StretchAverage::Impl::scale_change(double by, double step) {
  change = by * change + step * inverse.cwiseProduct(residual);
}

/// From the mean over the nearest points, which leaves nothing of an even field.
void StretchAverage::Impl::solve() {
  for (Eigen::Index n = 0; n < right.rows(); ++n) mean.row(n) = right.row(n) / weight[static_cast<std::size_t>(n)];
  const double middle = 0.5 * (high + low), half = 0.5 * (high - low), sigma = middle / half;
  double rho = 1 / sigma;
  for (int k = 0; k < degree; ++k) {
    find_residual();
    if (k == 0) {
      scale_change(0, 1 / middle);
    } else {
      const double next = 1 / (2 * sigma - rho);
      scale_change(next * rho, 2 * next / half);
      rho = next;
    }
    mean += change;
  }
}

StretchAverage::StretchAverage(Problem& problem, const std::vector<std::size_t>& points, double length)
    : impl_(std::make_unique<Impl>(problem, points, length)) {}
StretchAverage::~StretchAverage() = default;

int StretchAverage::degree() const { return impl_->degree; }

void StretchAverage::operator()(std::span<const double> field, std::span<double> mean) {
  Impl& s = *impl_;
  s.load(field);
  s.solve();
  const auto corners = static_cast<std::size_t>(s.corners);
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    double* t = mean.data() + 6 * i;
    std::fill_n(t, 6, 0.0);
    for (std::size_t c = 0; c < s.columns.size(); ++c) {
      double value = 0;
      for (std::size_t a = i * corners; a < (i + 1) * corners; ++a)
        value += s.shares[a] * s.mean(s.nodes[a], static_cast<Eigen::Index>(c));
      for (std::size_t k = 0; k < 6; ++k) t[k] += s.columns[c].back * s.columns[c].of[k] * value;
    }
  }
}

double StretchAverage::left_over() {
  Impl& s = *impl_;
  s.find_residual();
  const double now = s.norm(s.residual);
  const Fields answer = s.mean;
  for (Eigen::Index n = 0; n < s.right.rows(); ++n)
    s.mean.row(n) = s.right.row(n) / s.weight[static_cast<std::size_t>(n)];
  s.find_residual();
  const double first = s.norm(s.residual), all = s.norm(s.right);
  s.mean = answer;
  return first > 1e-13 * all ? now / first : 0;  // an even field leaves nothing but round-off
}

}  // namespace grus::fem
