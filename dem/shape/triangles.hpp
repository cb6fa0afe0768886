// SPDX-License-Identifier: LGPL-3.0-or-later
// A surface of triangles: what of it is near a place. It has no inside; nothing hangs on which way round a triangle is.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "dem/base/tensor.hpp"

namespace grus::dem {

/// Triangles of the surface by the cubes of a grid that they reach into.
struct TriangleGrid {
  Vec3 low = Vec3::Zero();
  double width = 0;  // m, of a cube
  std::array<Index, 3> cubes{};
  std::vector<Index> first, entry;  // entry[first[c]..first[c + 1]): triangles of cube c, ascending
};

struct Triangles {
  std::vector<Vec3> corner;  // m, in a frame of its own
  std::vector<std::array<Index, 3>> triangle;
  TriangleGrid grid;
};

/// The surface of these corners and triangles, of which those without an area are left out.
Triangles surface_of(std::vector<Vec3> corner, const std::vector<std::array<Index, 3>>& triangles);

/// Whether its numbers are those of a surface, with its grid.
bool sound_surface(const Triangles& surface);

/// The place of triangle t that is nearest to x.
Vec3 nearest_on(const Triangles& surface, Index t, const Vec3& x);

/// The triangles that are no further from x than `reach` (m), ascending, to `found`.
void triangles_near(const Triangles& surface, const Vec3& x, double reach, std::vector<Index>& found);

}  // namespace grus::dem
