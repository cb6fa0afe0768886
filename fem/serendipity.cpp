// SPDX-License-Identifier: LGPL-3.0-or-later
// Serendipity elements of order 2: those of Lagrange with the nodes inside tied to the ones on corners and edges.
#include "fem/serendipity.hpp"

#include <cmath>
#include <stdexcept>

namespace grus::fem {
namespace {

/// Serendipity function of the node at `a` (coordinates -1, 0 or 1, at most one of them 0), at `x`.
double value(std::span<const double> a, std::span<const double> x) {
  double product = 1, sum = 0;
  bool edge = false;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const bool along = std::abs(a[k]) < 0.5;
    edge = edge || along;
    product *= along ? 1 - x[k] * x[k] : 0.5 * (1 + a[k] * x[k]);
    sum += a[k] * x[k];
  }
  return edge ? product : product * (sum - static_cast<double>(a.size() - 1));
}

}  // namespace

Ties serendipity_ties(std::span<const double> nodes, std::size_t dim) {
  Ties ties;
  std::vector<double> centred;  // from (0, 1) to (-1, 1)
  for (const double x : nodes) centred.push_back(std::round(4 * x - 2) / 2);
  const std::size_t count = nodes.size() / dim;
  auto at = [&](std::size_t n) { return std::span<const double>(centred).subspan(n * dim, dim); };
  for (std::size_t n = 0; n < count; ++n) {
    std::size_t zeros = 0;
    for (const double x : at(n)) zeros += x == 0 ? 1 : 0;
    (zeros > 1 ? ties.inside : ties.kept).push_back(n);
  }
  for (const std::size_t n : ties.inside) {
    ties.weights.emplace_back();
    for (const std::size_t a : ties.kept) ties.weights.back().push_back(value(at(a), at(n)));
  }
  return ties;
}

void tie(const Ties& ties, std::size_t nodes, std::vector<double>& values) {
  for (double* row = values.data(); row != values.data() + values.size(); row += nodes)
    for (std::size_t i = 0; i < ties.inside.size(); ++i) {
      double& inner = row[ties.inside[i]];
      for (std::size_t a = 0; a < ties.kept.size(); ++a) row[ties.kept[a]] += ties.weights[i][a] * inner;
      inner = 0;
    }
}

}  // namespace grus::fem
