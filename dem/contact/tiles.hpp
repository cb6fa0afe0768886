// SPDX-License-Identifier: LGPL-3.0-or-later
// How a list's pairs are dealt to tiles, so that each tile is one thread's work; see state/contacts.hpp.
#pragma once

#include <span>

#include "dem/state/boundary.hpp"
#include "dem/state/contacts.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// What tile t, grains [begin, end), costs in a step, by measured costs: into tile_work[t + 1], not yet summed.
void weigh_tile(const Grains& grains, std::size_t t, std::size_t begin, std::size_t end, Contacts& contacts);

/// What b feels goes to b's own row in the same tile, else to a row of the tile of a and b together: a tile writes to
/// rows that lie side by side, in the order of b, and so does read each tile that collects them. `crossing`: the pairs
/// between tiles, by tile of a. `receivers`, `next`: room.
void assign_targets(std::size_t grains, std::span<const std::vector<Index>> crossing, Contacts& contacts,
                    std::vector<Index>& receivers, std::vector<Index>& next);

/// Numbers the images of a periodic cell that pairs reach across.
void index_images(const Cell& cell, Contacts& contacts);

}  // namespace grus::dem
