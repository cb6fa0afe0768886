// SPDX-License-Identifier: LGPL-3.0-or-later
// Equal states, equal numbers: what tests of "the same bits" compare.
#pragma once

#include "dem/rve/state.hpp"

namespace grus::dem {

/// Hash (FNV-1a) of every bit that decides how a state goes on: all columns of the grains, pairs and histories of the
/// contacts, springs, walls, cell and time. What depends on clocks, such as the tiles' costs, is left out, and so is
/// what is shown of contacts.
std::uint64_t hash(const State& state);

}  // namespace grus::dem
