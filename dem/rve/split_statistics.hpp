// SPDX-License-Identifier: LGPL-3.0-or-later
// The cost of splits: contacts and force that the parents had and the halves kept, and the jump of the sample's
// pressure.
#pragma once

#include <span>
#include <vector>

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// Touching contacts of grains about to split: neighbour (walls counted from the end of the grains), normal force (N).
struct ParentContacts {
  std::vector<std::vector<std::pair<std::size_t, double>>> of;
  double virial = 0;  // sum of force . branch over all contacts (J): 3 V x pressure
};

ParentContacts contacts_of(const Model& model, const State& state, std::span<const std::size_t> grains);

/// Adds to ledger.splits. `halves[k]` are the slots of the two halves of grain k of `before`; `origin` maps slots to
/// the slots before the split.
void count_split(const Model& model, State& state, const ParentContacts& before,
                 std::span<const std::vector<std::size_t>> pieces, std::span<const Index> origin,
                 std::size_t grains_before);

}  // namespace grus::dem
