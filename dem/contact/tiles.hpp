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

/// What b feels goes to b's own row in the same tile, else to a row for this pair alone, in the order of (b, pair).
/// `crossing`: the pairs between tiles, by tile of a. `next`: room.
void assign_targets(std::size_t grains, std::span<const std::vector<Index>> crossing, Contacts& contacts, std::vector<Index>& next);

/// Numbers the images of a periodic cell that pairs reach across.
void index_images(const Cell& cell, Contacts& contacts);

}  // namespace grus::dem
