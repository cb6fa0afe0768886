// SPDX-License-Identifier: LGPL-3.0-or-later
// Bodies of other programs: their surfaces as files tell them, and the convex bodies that these bound.
#pragma once

#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "dem/shape/polyhedron.hpp"

namespace grus::dem {

/// What bounds a body: polygons or triangles, either way round.
struct Surface {
  std::vector<Vec3> corner = {};            // in the file's unit
  std::vector<std::vector<int>> face = {};  // corners in turn; none: the convex hull of all
  std::vector<std::string> group = {};      // what the file calls it, its material and its group
  std::string name = {};                    // for messages: file, line or number
  std::optional<Vec3> seed = {};            // of a Voronoi cell
};

/// Those of a file, by the ending of its name: .stl, .obj and .ply (parts of a solid or an object that share no corner
/// are bodies of their own), Neper's .tess, or lists of the corners of convex bodies, one a line, with a blank line
/// between two bodies. Throws InputError with file and line.
std::vector<Surface> read_surfaces(const std::string& path);

/// The convex body that it bounds: triangles and polygons in one plane become one face. `tolerance`: of planes and
/// corners, over the body's size. Tags of faces count from 0. Throws InputError where it is bent, open, not convex, or
/// has more faces or corners than a hull has room for.
Polyhedron body_of(const Surface& surface, double tolerance);

/// How far off corners and planes of a body may be (m): `tolerance` of its size, and what numbers of single precision
/// leave where it is.
double slack_of(const std::vector<Vec3>& corners, double tolerance);

/// Parts of a surface that share no corner, corners at one place taken for one.
std::vector<Surface> parts_of(const Surface& surface);

/// Neper's tessellations; a PLY file as one surface. `path`: for messages.
std::vector<Surface> read_tess(std::istream& in, const std::string& path);
Surface read_ply(std::istream& in, const std::string& path);

}  // namespace grus::dem
