// SPDX-License-Identifier: LGPL-3.0-or-later
// Private to fem: how the inner nodes of a second-order Lagrange element follow those on corners and edges.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace grus::fem {

struct Ties {
  std::vector<std::size_t> kept, inside;     // local nodes: on corners and edges; tied
  std::vector<std::vector<double>> weights;  // of each node inside: of each that is kept
};

/// `nodes`: of the reference element [0, 1]^dim, (count, dim).
Ties serendipity_ties(std::span<const double> nodes, std::size_t dim);

/// Tables of basis functions, rows of `nodes` values: the kept ones take the tied ones' share, which become zero.
void tie(const Ties& ties, std::size_t nodes, std::vector<double>& values);

}  // namespace grus::fem
