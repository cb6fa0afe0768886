// SPDX-License-Identifier: LGPL-3.0-or-later
// Which rank owns which element: parts of equal cost along Hilbert's curve, so that each part lies together.
#pragma once

#include <cstdint>
#include <vector>

#include "fem/mesh.hpp"

namespace grus::fem {

/// Place of a cell of a grid of 2^bits cells a side along Hilbert's curve, in 2 or 3 dimensions (Skilling, AIP Conf.
/// Proc. 707, 2004). `at`: below 2^bits each; bits <= 20.
std::uint64_t hilbert_place(std::array<std::uint32_t, 3> at, int dimensions, int bits);

/// Part (0 .. parts - 1) of each element: in the order of their middles along the curve, cut where the sum of costs
/// (any unit, not all 0) passes a multiple of its share. Middles in one plane across z are cut along the curve of the
/// plane. The same on all ranks for the same numbers.
std::vector<std::int32_t> hilbert_cut(const std::vector<Point>& middles, const std::vector<double>& costs, int parts);

}  // namespace grus::fem
