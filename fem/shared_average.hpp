// SPDX-License-Identifier: LGPL-3.0-or-later
// Private to fem: the average of a problem that may lie on many ranks, with the same bits on any number of them.
#pragma once

#include "fem/average_elements.hpp"

namespace grus::fem {

/// What elements give to a node is divided by the node's diagonal, rounded to multiples of one quantum and added as
/// integers. The quantum is 2^-40 of the power of two above the field's largest number anywhere: each sum is off by
/// some 1e-12 of that. A polynomial of fixed degree asks for no other sum. All ranks must call the same members.
class SharedAverage {
public:
  SharedAverage(const AverageElements& of, double length, double promised, int most_degree);

  /// True where any rank `asks`.
  bool operator()(std::span<const double> field, std::span<double> mean, bool asks);
  double left_over();
  int degree() const { return steps_->degree; }

private:
  using Numbers = dolfinx::la::Vector<double>;
  struct Cell {
    std::size_t first, end;  // points
    std::size_t matrix;      // where its matrix begins
  };

  template <class Give>
  void add_up(std::vector<double>& owned, Give&& give);
  void give_to_nodes(const std::vector<double>& scale, std::vector<double>& owned);
  void mean_of_nearest();
  void find_residual();
  double squared(const std::vector<double>& scaled) const;
  void find_scales();
  std::size_t place(std::int32_t node, std::size_t column) const {
    return static_cast<std::size_t>(node) * width_ + column;
  }

  const AverageElements& of_;
  std::size_t width_;  // columns
  std::vector<Cell> cells_;
  std::vector<double> plain_, turning_;  // matrices, row by row; turning: about an axis only
  std::vector<double> right_;            // of the elements: corners by columns
  dolfinx::la::Vector<std::int64_t> sum_;
  Numbers mean_;
  std::vector<double> inverse_, lightness_;  // of owned and ghost nodes by columns: 1 / diagonal, 1 / weight (1/m^3)
  std::vector<double> residual_, change_;    // of owned nodes by columns; residual: over the diagonal
  std::optional<ChebyshevSteps> steps_;
  double up_ = 0;         // quanta in one
  bool too_big_ = false;  // a contribution has been: the next field has no mean, on any rank
};

}  // namespace grus::fem
