// SPDX-License-Identifier: LGPL-3.0-or-later
// Candidate pairs from a hierarchy of grids, one level for each factor of two in size: cost does not depend on the
// size ratio. Periodic cells of any shape are searched in fractional coordinates.
#pragma once

#include <array>
#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/state/boundary.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

struct Candidate {
  Index a, b;  // a < b
  std::array<std::int16_t, 3> image;  // cell vectors to add to b
};

/// Pairs of grain a: pair[row[a]] to pair[row[a + 1]], by (b, image).
struct Candidates {
  std::vector<Candidate> pair;
  std::vector<Index> row;
};

/// All pairs whose bounding spheres are closer than `skin`, each once.
/// Throws InputError where a periodic cell is too small for its largest grain (a grain would meet its own image).
Candidates find_candidates(const Grains& grains, const Cell& cell, double skin, Team& team);

}  // namespace grus::dem
