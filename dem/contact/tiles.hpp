// SPDX-License-Identifier: LGPL-3.0-or-later
// How a list's pairs are dealt to tiles, so that each tile is one thread's work; see state/contacts.hpp.
#pragma once

#include <span>

#include "dem/state/boundary.hpp"
#include "dem/state/contacts.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// Room for the columns that the kernels read of pairs, with those beyond the last: `overrun`, and of grains b as many
/// more as kernels look ahead.
void make_room(std::size_t pairs, Plan& plan);

/// Writes what the kernels read of pair k of tile t; `crossing` collects those whose grain b is in a later tile.
inline void plan_pair(const Pair& pair, std::size_t k, std::size_t t, bool wall, int bits, Plan& plan,
                      std::vector<Index>& crossing) {
  plan.a[k] = pair.a;
  plan.b[k] = wall ? 0 : pair.b;
  plan.law[k] = pair.law;
  plan.target[k] = pair.b;
  if (!wall && pair.b >> bits != t) crossing.push_back(static_cast<Index>(k));
}

/// What tile t costs in a step, by measured costs of pairs and grains: into tile_work[t + 1], not yet summed.
void weigh_tile(const Grains& grains, std::size_t t, Contacts& contacts);

/// The plan of pairs whose columns are written: rows of loads, images, costs of tiles. What b feels goes to b's own row
/// in the same tile, else to a row of the tile of a and b together: a tile writes to rows that lie side by side, in the
/// order of b, and so does read each tile that collects them. `crossing`: the pairs between tiles, by tile of a.
/// `receivers`, `next`: room.
void finish_plan(const Grains& grains, const Cell& cell, std::span<const std::vector<Index>> crossing,
                 Contacts& contacts, std::vector<Index>& receivers, std::vector<Index>& next);

/// Numbers the images of a periodic cell that pairs reach across.
void index_images(const Cell& cell, Contacts& contacts);

/// The plan of a list of which only the pairs, bins and tiles are known: that of its first making, bit for bit.
void entail(const Grains& grains, const Cell& cell, Contacts& contacts);

}  // namespace grus::dem
