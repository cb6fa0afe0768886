// SPDX-License-Identifier: LGPL-3.0-or-later
// Cells that share faces: their bonds are made, keep their pairs off the neighbour list, and go over into contacts.
#pragma once

#include "dem/packing/voronoi.hpp"
#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// What became of the faces that cells share.
struct BondedFaces {
  std::size_t bonds = 0;
  std::size_t unbonded = 0;  // smaller than 1e-6 of the cells' distance squared
  std::size_t coarse = 0;    // too far apart for the energy: of less tension than asked for
};

/// Puts cells into the state as hulls of a material, at rest, and bonds of its kind on the faces they share (none
/// without a bond model). The faces' numbers are those of the cells. Throws InputError.
BondedFaces add_cells(const Model& model, const VoronoiCells& cells, std::uint8_t material, State& state);

/// In the step in which bonds have broken: what a contact of the same two holds less than the bond did is booked as
/// taken by fracture (more: negative).
void book_broken(State& state);

/// Before a neighbour list: the pairs that bonds hold.
void note_bonded(State& state);

/// After it: contacts go on with what broken bonds have left.
void take_over(State& state);

/// Groups of cells that bonds hold together, those without bonds alone: sizes, largest first, and each grain's group.
struct Fragments {
  std::vector<std::size_t> size;
  std::vector<Index> of;
};
Fragments fragments_of(const State& state);

}  // namespace grus::dem
