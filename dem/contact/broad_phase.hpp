// SPDX-License-Identifier: LGPL-3.0-or-later
// Candidate pairs from a hierarchy of grids, one level for each factor of two in size: cost does not depend on the
// size ratio. Periodic cells of any shape are searched in fractional coordinates.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/state/boundary.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

struct Candidate {
  Index a, b;                         // a < b
  std::array<std::int16_t, 3> image;  // cell vectors to add to b
};

/// Pairs of grain a: pair[row[a]] to pair[row[a + 1]], by (b, image).
struct Candidates {
  std::vector<Candidate> pair;
  std::vector<Index> row;
};

/// Samples of more grains are searched seldom: what only that needs is given back as soon as nothing reads it any more.
inline constexpr std::size_t large_sample = 20000;

/// Room that searches of smaller samples reuse.
struct SearchRoom {
  struct Member {   // of a grid cell
    Vec3 position;  // folded into the cell, from its corner
    double radius;
    Index grain;
    std::array<std::int16_t, 3> fold;  // cell vectors taken off
  };
  struct Level {
    double largest = 0;  // radius
    std::array<int, 3> cells{1, 1, 1};
    std::vector<Index> first;
    std::vector<Member> member;  // by cell, x fastest
  };
  std::vector<Level> levels;
  std::vector<Member> folded;
  std::vector<std::uint8_t> level_of;
  std::vector<Index> place, next;
  std::vector<std::vector<Candidate>> piece;
};

/// All pairs whose bounding spheres are closer than `skin`, each once.
/// Throws Unstable where a periodic cell has become too small for its largest grain (a grain would meet its own image).
void find_candidates(const Grains& grains, const Cell& cell, double skin, Candidates& found, SearchRoom& room,
                     Team& team);

/// Throws InputError where a cell is too small to begin with.
void refuse_small_cell(const Grains& grains, const Cell& cell, double skin);

/// Those of them that a grain of `few` is part of; marked[i]: grain i is one of the few.
void find_candidates_of(std::span<const Index> few, const std::vector<std::uint8_t>& marked, const Grains& grains,
                        const Cell& cell, double skin, Candidates& found, SearchRoom& room, Team& team);

}  // namespace grus::dem
