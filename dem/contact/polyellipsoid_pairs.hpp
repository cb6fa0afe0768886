// SPDX-License-Identifier: LGPL-3.0-or-later
// Pairs that involve a poly-ellipsoid: rows of the table of pairs.
#pragma once

#include "dem/contact/pair_kinds.hpp"

namespace grus::dem {

/// The passes; see PairKind.
void polyellipsoids(const TileWork& work, std::size_t begin, std::size_t end);
void polyellipsoids_at_walls(const TileWork& work, std::size_t begin, std::size_t end);

/// Exact-gap test; see PairKind.
bool near(const Grains& grains, const Cell& cell, const Candidate& pair, double skin, Vec3& normal);

}  // namespace grus::dem
