// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/block_cholesky.hpp"

#include <Eigen/OrderingMethods>
#include <algorithm>

namespace grus::dem {

BlockCholesky::BlockCholesky(std::size_t rows, std::span<const std::pair<int, int>> links) : place_(rows) {
  const auto n = static_cast<Eigen::Index>(rows);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < n; ++i) entries.emplace_back(i, i, 1);
  for (const auto& [i, j] : links) entries.emplace_back(i, j, 1), entries.emplace_back(j, i, 1);
  Eigen::SparseMatrix<double> graph(n, n);
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(graph, order);
  for (std::size_t i = 0; i < rows; ++i)
    place_[static_cast<std::size_t>(order.indices()[static_cast<Eigen::Index>(i)])] = static_cast<int>(i);
  std::vector<std::vector<int>> column(rows);
  for (const auto& [i, j] : links) {
    const int a = place_[static_cast<std::size_t>(i)], b = place_[static_cast<std::size_t>(j)];
    column[static_cast<std::size_t>(std::min(a, b))].push_back(std::max(a, b));
  }
  begin_.assign(1, 0);
  for (auto& c : column) {  // what an eliminated row has met, its parent in the elimination tree meets
    std::sort(c.begin(), c.end());
    c.erase(std::unique(c.begin(), c.end()), c.end());
    if (c.size() > 1) {
      auto& parent = column[static_cast<std::size_t>(c.front())];
      parent.insert(parent.end(), c.begin() + 1, c.end());
    }
    row_.insert(row_.end(), c.begin(), c.end());
    begin_.push_back(row_.size());
  }
  diagonal_.assign(rows, Mat6::Zero());
  below_.assign(row_.size(), Mat6::Zero());
}

Mat6& BlockCholesky::at(int row, int column) {
  const auto first = row_.begin() + static_cast<std::ptrdiff_t>(begin_[static_cast<std::size_t>(column)]);
  const auto last = row_.begin() + static_cast<std::ptrdiff_t>(begin_[static_cast<std::size_t>(column) + 1]);
  return below_[static_cast<std::size_t>(std::lower_bound(first, last, row) - row_.begin())];
}

void BlockCholesky::add(int i, int j, const Mat6& block) {
  const int a = place_[static_cast<std::size_t>(i)], b = place_[static_cast<std::size_t>(j)];
  if (a == b)
    diagonal_[static_cast<std::size_t>(a)] += block;
  else if (a > b)
    at(a, b) += block;
  else
    at(b, a) += block.transpose();
}

bool BlockCholesky::factorise() {
  for (std::size_t k = 0; k < diagonal_.size(); ++k) {
    const Mat6 inverse = diagonal_[k].inverse();
    if (!inverse.allFinite()) return false;
    diagonal_[k] = inverse;
    for (std::size_t j = begin_[k]; j < begin_[k + 1]; ++j) {
      // Column j of what is left loses L(., k) D(k) L(j, k)^T: rows of column k are among those of column j.
      const Mat6 whole = below_[j], share = whole * inverse;
      const auto c = static_cast<std::size_t>(row_[j]);
      diagonal_[c].noalias() -= share * whole.transpose();
      std::size_t to = begin_[c];
      for (std::size_t i = j + 1; i < begin_[k + 1]; ++i) {
        while (row_[to] != row_[i]) ++to;
        below_[to].noalias() -= below_[i] * share.transpose();
      }
      below_[j] = share;
    }
  }
  return true;
}

void BlockCholesky::solve(Eigen::MatrixXd& x) const {
  Eigen::MatrixXd y(x.rows(), x.cols());
  auto block = [](auto& m, auto k) { return m.template middleRows<6>(6 * static_cast<Eigen::Index>(k)); };
  for (std::size_t i = 0; i < place_.size(); ++i) block(y, place_[i]) = block(x, i);
  for (std::size_t k = 0; k < place_.size(); ++k)
    for (std::size_t j = begin_[k]; j < begin_[k + 1]; ++j) block(y, row_[j]) -= below_[j] * block(y, k);
  for (std::size_t k = place_.size(); k-- > 0;) {
    block(y, k) = (diagonal_[k] * block(y, k)).eval();
    for (std::size_t j = begin_[k]; j < begin_[k + 1]; ++j) block(y, k) -= below_[j].transpose() * block(y, row_[j]);
  }
  for (std::size_t i = 0; i < place_.size(); ++i) block(x, i) = block(y, place_[i]);
}

}  // namespace grus::dem
