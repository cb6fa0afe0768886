// SPDX-License-Identifier: LGPL-3.0-or-later
// Two hulls of one, by a plane: nothing is lost but planes of pieces that have too many (shape/fewer_planes.hpp).
#pragma once

#include "dem/fracture/splitter.hpp"

namespace grus::dem {

bool can_split(const Cut& splitter, const Grains& grains, std::size_t i);
Pieces pieces_of(const Cut& splitter, const Grains& grains, std::size_t i, const Wanted& wanted, std::uint64_t seed);

/// Rows of the grains' hulls for the bodies of pieces; a store that other states share is copied first.
void put_bodies(Grains& grains, std::size_t i, Pieces& pieces);

}  // namespace grus::dem
