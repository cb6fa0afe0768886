// SPDX-License-Identifier: LGPL-3.0-or-later
// Voronoi cells as grains, and the bonds of the faces that they share.
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

}  // namespace grus::dem
