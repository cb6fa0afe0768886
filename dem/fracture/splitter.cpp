// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/splitter.hpp"

#include "dem/fracture/apollonian.hpp"
#include "dem/fracture/shatter.hpp"
#include "dem/fracture/split_hull.hpp"
#include "dem/fracture/split_polyellipsoid.hpp"

namespace grus::dem {

bool can_split(const Splitter& splitter, const Grains& grains, std::size_t i) {
  return std::visit([&](const auto& s) { return can_split(s, grains, i); }, splitter);
}

Pieces pieces_of(const Splitter& splitter, const Grains& grains, std::size_t i, const Wanted& wanted,
                 std::uint64_t seed) {
  return std::visit([&](const auto& s) { return pieces_of(s, grains, i, wanted, seed); }, splitter);
}

}  // namespace grus::dem
