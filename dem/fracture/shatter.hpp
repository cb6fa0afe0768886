// SPDX-License-Identifier: LGPL-3.0-or-later
// As many hulls of one as its cracks say: whoever tests the grain labels points in it, and the parts tile it.
#pragma once

#include <span>

#include "dem/fracture/splitter.hpp"

namespace grus::dem {

inline bool can_split(const Shatter&, const Grains& g, std::size_t i) { return g.kind[i] == ShapeKind::hull; }

/// Only who has tested the grain knows: breaks carry their pieces.
Pieces pieces_of(const Shatter& splitter, const Grains& g, std::size_t i, const Wanted& wanted, std::uint64_t seed);

/// What the labels (0 to count - 1; below 0: of nobody) of points (m, the grain's geometry frame) make of it; no piece
/// where it stays whole: thin wedges alone, or parts that no hull has room for. `misfit`: share of the points that lie
/// in another's part. The last `crumbs` labels become fines.
Pieces pieces_by_labels(const Shatter& splitter, const Grains& grains, std::size_t i, std::span<const Vec3> points,
                        std::span<const int> label, std::size_t count, double* misfit = nullptr,
                        std::size_t crumbs = 0);

}  // namespace grus::dem
