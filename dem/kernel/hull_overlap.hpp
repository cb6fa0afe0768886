// SPDX-License-Identifier: LGPL-3.0-or-later
// The overlap of two convex hulls (shape/overlap.hpp says what it means), many corners at a time. Built for several
// instruction sets, as contact_pass.hpp.
#pragma once

#include <cstdint>

namespace grus::dem {

/// One hull in its own frame.
struct HullColumns {
  const double* corner;  // x, y, z: a column of `room` each; beyond the last the first again
  const double* side;    // planes: normal x, y, z, offset: a column of `space` each; beyond the last 0, 0, 0, infinity
  const std::uint8_t* edge;  // rows of 4: from, to, face that runs so, face that runs the other way
  const double* row;         // corners once more: rows of x, y, z, 0
  const double* plane;       // planes once more: rows of normal, offset, as many as `space`
  const std::uint64_t* at;   // rows of 3 by corner, bit by bit: its faces; its edges, two
  int room, space, vertices, faces, edges;
};

/// Poses of A and B, and a direction from A to B: a unit vector, as good as is known. It decides what is looked at, not
/// what is found.
struct HullPose {
  const double *a, *b;  // axes: own frame -> global, 9 numbers column by column
  const double* shift;  // from A's origin to B's (global)
  const double* search;
  double flush;  // share of the size below which planes count as one: B counts as the larger by so much
  double thin;   // so many flush distances of mean depth are no overlap yet
  double clear;  // share of the size: a guess holds where all that it says is true by so much
};

/// As Overlap, for c = 1, in the global frame about A's origin.
struct HullWrench {
  double volume, energy, polar;
  double force[3], moment[3], area[3], middle[3];
  double gap;  // of parted hulls, along `search`
};

/// What the two hulls' overlap was made of when it was last found: a guess of what it is made of now. Whether it holds
/// is looked at, so it decides no bit of what is found. One of too many edges is not kept.
struct HullGuess {
  static constexpr int most_octets = 4, most_borders = 56;
  std::uint8_t octets = 0, octets_a = 0, borders = 0, borders_a = 0;  // octets 0: none
  std::uint8_t cut_from[most_octets], cut_to[most_octets], new_from[most_octets], new_to[most_octets];
  std::uint8_t from[8 * most_octets], to[8 * most_octets], enters[8 * most_octets], leaves[8 * most_octets];
  std::uint8_t border[4][most_borders];
};

enum class Meets {
  parted,    // along `search`
  apart,     // some other direction parts them
  overlaps,  // `out` is filled
  unsettled  // edges and faces cross each other where round-off decides: ask overlap_by_faces
};

/// `guess` may be null; it is renewed.
using HullOverlap = Meets (*)(const HullColumns& a, const HullColumns& b, const HullPose&, HullGuess* guess,
                              HullWrench& out);
HullOverlap hull_overlap();

#define GRUS_DECLARE_LANES(name)                                                                         \
  namespace name {                                                                                       \
  Meets hull_overlap(const HullColumns& a, const HullColumns& b, const HullPose& pose, HullGuess* guess, \
                     HullWrench& out);                                                                   \
  }
GRUS_DECLARE_LANES(lanes1)
GRUS_DECLARE_LANES(lanes4)
GRUS_DECLARE_LANES(lanes8)
#undef GRUS_DECLARE_LANES

}  // namespace grus::dem
