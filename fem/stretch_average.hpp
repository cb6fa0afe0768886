// SPDX-License-Identifier: LGPL-3.0-or-later
// The average of a field of symmetric tensors at Gauss points over a length: mean - l^2 Laplace(mean) = field, no flux
// through the surface of the points' elements (Peerlings et al. 1996), on the mesh's corners.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fem/problem.hpp"

namespace grus::fem {

class StretchAverage {
public:
  /// Over the elements of `points`; `length` in m. Of a problem with exact sums, which may lie on many ranks, all of
  /// them must call the same members, and the means are the same to the bit on any number. Throws std::invalid_argument
  /// for other problems on several ranks, and for a length that needs a polynomial of more than `most_degree`.
  StretchAverage(Problem& problem, const std::vector<std::size_t>& points, double length);
  ~StretchAverage();
  StretchAverage(const StretchAverage&) = delete;
  StretchAverage& operator=(const StretchAverage&) = delete;

  /// (n, 6) tensors in and out: xx yy zz yz xz xy, none of them doubled. An even field is its own mean. True where any
  /// rank `asks`.
  bool operator()(std::span<const double> field, std::span<double> mean, bool asks = false);
  /// What the last answer leaves of the equation, relative to what a mean over the nearest points leaves, in the norm
  /// of which `promised` is the bound. Costs as much as one degree.
  double left_over();

  int degree() const;  // of the Chebyshev polynomial that stands for the inverse
  static constexpr double promised = 1e-3;
  static constexpr int most_degree = 20000;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace grus::fem
