// SPDX-License-Identifier: LGPL-3.0-or-later
// A periodic cell that is sheared without end: other edges of the same lattice, before it is too thin for its grains.
#pragma once

#include "dem/rve/state.hpp"

namespace grus::dem {

/// Whole numbers M, det M = 1: the columns of vectors * M span the same lattice and are as short as can be (Semaev's
/// reduction, 2001: none is longer than its sum with whole multiples of the others).
Mat3 shortest_edges(const Mat3& vectors);

/// Cuts the cell anew where its least height (Cell::height) grows by a factor of `gain` or more; true: done. Grains,
/// histories, forces and the lattice stay; edges, their rate and the images of pairs and bonds are told anew. To be
/// followed by a new list. Throws Unstable where a grain is 30,000 cells away from one that it touches.
bool reduce_cell(State& state, double gain);

}  // namespace grus::dem
