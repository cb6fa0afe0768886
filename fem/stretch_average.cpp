// SPDX-License-Identifier: LGPL-3.0-or-later
// The equation is solved by a Chebyshev polynomial of its matrix over its diagonal: a fixed number of products, no sum
// over nodes. On one rank by a sparse matrix; with exact sums element by element (fem/shared_average.hpp).
#include "fem/stretch_average.hpp"

#include <Eigen/Sparse>
#include <array>
#include <cmath>

#include "fem/shared_average.hpp"

namespace grus::fem {
namespace {

using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor, std::int32_t>;
using Fields = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;  // nodes, columns

}  // namespace

struct StretchAverage::Impl {
  AverageElements elements;
  std::optional<SharedAverage> shared;  // where sums are exact; what follows is for one rank
  std::vector<std::int32_t> nodes;      // of a point's element, numbered as they come
  std::vector<double> weight;           // of the nodes, m^3
  Sparse plain, turning;                // of one pattern
  Fields inverse;                       // of the diagonal
  std::optional<ChebyshevSteps> steps;
  Fields right, mean, residual, change;

  Impl(Problem& problem, const std::vector<std::size_t>& which, double length);
  void number_nodes();
  void assemble(double length);
  void load(std::span<const double> field);
  void solve();
  /// residual = right - matrix x mean
  void find_residual();
  double norm(const Fields& of) const { return std::sqrt(of.cwiseProduct(of.cwiseProduct(inverse)).sum()); }
};

StretchAverage::Impl::Impl(Problem& problem, const std::vector<std::size_t>& which, double length)
    : elements(problem, which) {
  const Problem::Impl& p = elements.p;
  if (p.discretisation.exact_sums) {
    shared.emplace(elements, length, promised, most_degree);
    return;
  }
  int ranks = 1;
  MPI_Comm_size(p.comm, &ranks);
  if (ranks > 1) throw std::invalid_argument("an average over a length needs the mesh on one rank, or exact sums");
  number_nodes();
  assemble(length);
}

void StretchAverage::Impl::number_nodes() {
  std::vector<std::int32_t> number(elements.p.mesh->geometry().x().size() / 3, -1);
  std::int32_t count = 0;
  for (const std::int32_t dof : elements.nodes) {
    std::int32_t& n = number[static_cast<std::size_t>(dof)];
    if (n < 0) n = count++;
    nodes.push_back(n);
  }
  weight.assign(static_cast<std::size_t>(count), 0);
  const auto corners = static_cast<std::size_t>(elements.corners);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    weight[static_cast<std::size_t>(nodes[k])] += elements.volumes[k / corners] * elements.shares[k];
}

void StretchAverage::Impl::assemble(double length) {
  const int corners = elements.corners;
  const auto count = static_cast<Eigen::Index>(weight.size());
  std::array<double, 2> bounds{INFINITY, 0};
  std::vector<Eigen::Triplet<double, std::int32_t>> of_plain, of_turning;
  elements.each([&](std::size_t first, std::size_t end) {
    const AverageElements::Element e = elements.element(first, end, length);
    elements.widen(bounds, e);
    const std::int32_t* at = nodes.data() + first * static_cast<std::size_t>(corners);
    for (int a = 0; a < corners; ++a)
      for (int b = 0; b < corners; ++b)
        of_plain.emplace_back(at[a], at[b], e.plain(a, b)), of_turning.emplace_back(at[a], at[b], e.turning(a, b));
  });
  steps.emplace(bounds, promised, most_degree);
  plain.resize(count, count), turning.resize(count, count);
  plain.setFromTriplets(of_plain.begin(), of_plain.end());
  turning.setFromTriplets(of_turning.begin(), of_turning.end());
  inverse.resize(count, static_cast<Eigen::Index>(elements.columns.size()));
  for (Eigen::Index k = 0; k < inverse.cols(); ++k)
    inverse.col(k) =
        (plain.diagonal() + elements.columns[static_cast<std::size_t>(k)].turns * turning.diagonal()).cwiseInverse();
  right = mean = residual = change = Fields::Zero(count, inverse.cols());
}

void StretchAverage::Impl::load(std::span<const double> field) {
  right.setZero();
  const auto corners = static_cast<std::size_t>(elements.corners);
  for (std::size_t i = 0; i < elements.points.size(); ++i)
    elements.load(i, field.data() + 6 * i, [&](std::size_t a, std::size_t c, double value) {
      right(nodes[i * corners + a], static_cast<Eigen::Index>(c)) += value;
    });
}

void StretchAverage::Impl::find_residual() {
  for (Eigen::Index row = 0; row < right.rows(); ++row)
    for (Eigen::Index k = 0; k < right.cols(); ++k) {
      const double turns = elements.columns[static_cast<std::size_t>(k)].turns;
      double sum = right(row, k);
      for (auto j = plain.outerIndexPtr()[row]; j < plain.outerIndexPtr()[row + 1]; ++j)
        sum -= (plain.valuePtr()[j] + turns * turning.valuePtr()[j]) * mean(plain.innerIndexPtr()[j], k);
      residual(row, k) = sum;
    }
}

/// From the mean over the nearest points, which leaves nothing of an even field.
void StretchAverage::Impl::solve() {
  for (Eigen::Index n = 0; n < right.rows(); ++n) mean.row(n) = right.row(n) / weight[static_cast<std::size_t>(n)];
  steps->each([&](double by, double share) {
    find_residual();
    change = by * change + share * inverse.cwiseProduct(residual);
    mean += change;
  });
}

StretchAverage::StretchAverage(Problem& problem, const std::vector<std::size_t>& points, double length)
    : impl_(std::make_unique<Impl>(problem, points, length)) {}
StretchAverage::~StretchAverage() = default;

int StretchAverage::degree() const { return impl_->shared ? impl_->shared->degree() : impl_->steps->degree; }

bool StretchAverage::operator()(std::span<const double> field, std::span<double> mean, bool asks) {
  Impl& s = *impl_;
  if (s.shared) return (*s.shared)(field, mean, asks);
  s.load(field);
  s.solve();
  const auto corners = static_cast<std::size_t>(s.elements.corners);
  for (std::size_t i = 0; i < s.elements.points.size(); ++i)
    s.elements.read(i, mean.data() + 6 * i, [&](std::size_t a, std::size_t c) {
      return s.mean(s.nodes[i * corners + a], static_cast<Eigen::Index>(c));
    });
  return asks;
}

double StretchAverage::left_over() {
  Impl& s = *impl_;
  if (s.shared) return s.shared->left_over();
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
