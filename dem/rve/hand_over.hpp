// SPDX-License-Identifier: LGPL-3.0-or-later
// Bonds of faces in a run: they keep their pairs off the neighbour list, go over into contacts, and hold fragments.
#pragma once

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// In the step in which bonds have broken: what a contact of the same two holds less than what is pressed of the bond
/// did is booked as handed (J); more is made of nothing, unexplained. `recorded`: they are noted in bonds.broken.
void book_broken(State& state, bool recorded);

/// Before a neighbour list: the pairs that bonds hold.
void note_bonded(State& state);

/// After it: contacts go on with what broken bonds have left.
void take_over(State& state);

/// Groups of Voronoi cells that bonds hold together, those without bonds alone: sizes, largest first, and each grain's
/// group.
struct Fragments {
  std::vector<std::size_t> size;
  std::vector<Index> of;
};
Fragments fragments_of(const State& state);

}  // namespace grus::dem
