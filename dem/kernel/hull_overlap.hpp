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
  int room, space, vertices, faces, edges;
};

/// Pose of B in the frame of A, x = turn x_b + shift, and a direction from A to B.
struct HullPose {
  double turn[9];  // row by row
  double shift[3], search[3];
  double flush;  // share of the size below which planes count as one: B counts as the larger by so much
  double thin;   // so many flush distances of mean depth are no overlap yet
};

/// As Overlap, for c = 1, in the frame of A.
struct HullWrench {
  double volume, energy, polar;
  double force[3], moment[3], area[3], middle[3];
};

enum class Meets {
  parted,    // along `search`
  apart,     // some other direction parts them
  overlaps,  // `out` is filled
  unsettled  // edges and faces cross each other where round-off decides: ask overlap_by_faces
};

using HullOverlap = Meets (*)(const HullColumns& a, const HullColumns& b, const HullPose&, HullWrench& out);
HullOverlap hull_overlap();

#define GRUS_DECLARE_LANES(name)                                                                         \
  namespace name {                                                                                       \
  Meets hull_overlap(const HullColumns& a, const HullColumns& b, const HullPose& pose, HullWrench& out); \
  }
GRUS_DECLARE_LANES(lanes1)
GRUS_DECLARE_LANES(lanes4)
GRUS_DECLARE_LANES(lanes8)
#undef GRUS_DECLARE_LANES

}  // namespace grus::dem
