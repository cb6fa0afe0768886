// SPDX-License-Identifier: LGPL-3.0-or-later
// Faces that bodies share: where they lie face to face, by their geometry alone.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "dem/shape/polyhedron.hpp"

namespace grus::dem {

/// What two bodies have in common of a plane; b is moved by `image` boxes.
struct SharedFace {
  std::size_t a, b;
  std::array<std::int16_t, 3> image{};
  FaceMoments face;
  Vec3 normal;  // of a
};

/// Bodies that lie in one another: how many pairs, and the one that does so most, by the common volume over the
/// smaller body's.
struct Overlaps {
  std::size_t pairs = 0, a = 0, b = 0;
  double share = 0;
};

struct SharedFaces {
  std::vector<SharedFace> face;                   // by a, b and image
  std::vector<std::vector<std::uint8_t>> shared;  // of each body: whether some of a face is
  Overlaps overlap;
};

/// `periodic`: sides of the box, or zero. `tolerance`: of the bodies' sizes, how far apart faces that count as one may
/// be, and how deep bodies are in one another that count as such. Throws InputError where a body meets its own image.
SharedFaces shared_faces(const std::vector<Polyhedron>& bodies, const Vec3& periodic, double tolerance);

}  // namespace grus::dem
