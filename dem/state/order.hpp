// SPDX-License-Identifier: LGPL-3.0-or-later
// The order of grains in memory: near in space, near in memory.
#pragma once

#include <span>

#include "dem/state/boundary.hpp"
#include "dem/state/contacts.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// The order along a space-filling (Morton) curve over the bounding box of the grains: what index each is to come from.
std::vector<Index> order_in_space(const Grains& grains);

/// Puts the grains in that order. Ids stay with their grains; indices held elsewhere (contacts, bonds) do not follow.
void reorder(Grains& grains, std::span<const Index> order);

/// Hulls of no grain and no roller leave the store once they are more than a quarter of it (2 kB each); the others keep
/// their order and their numbers. States that share the store keep theirs.
void free_hulls(Grains& grains, std::vector<Wall>& walls, HullGuesses& guesses);

/// For new samples: both.
void sort_in_space(Grains& grains);

}  // namespace grus::dem
