// SPDX-License-Identifier: LGPL-3.0-or-later
// Voronoi cells by cuts: each cell is its container cut by the planes half way to its neighbours, nearest first.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/shape/polyellipsoid.hpp"
#include "dem/shape/polyhedron.hpp"

namespace grus::dem {

/// A space that Voronoi cells fill: a convex body, or a periodic box with its corner at the origin.
struct TessellationSpace {
  Polyhedron body;         // empty of a periodic box
  Vec3 periodic{0, 0, 0};  // m
  bool extruded = false;   // all seeds in one plane across z: a mesh of the plane, drawn out
  double volume() const;
};

TessellationSpace box_space(const Vec3& box);
TessellationSpace periodic_space(const Vec3& box);
/// Tangent planes, 48 of them, about a circle of `diameter` in the middle of [diameter, diameter, length]; axis along
/// z.
TessellationSpace cylinder_space(double diameter, double length);

/// Upright over a convex polygon (corners counter-clockwise seen from +z), from z = 0.
TessellationSpace prism_space(std::span<const Vec3> corners, double height);
/// The shape as a polyhedron of its volume: tangent planes, moved inwards, as many (32 to 200) as `cells` of it can
/// share without too many faces each. Octants meet at the origin.
TessellationSpace polyellipsoid_space(const PolyEllipsoid& shape, double cells);

struct Tessellation {
  struct Partner {
    Index cell;
    std::array<std::int16_t, 3> image{};
  };
  std::vector<Vec3> seed;
  std::vector<Polyhedron> body;               // tag of a face: row of `partner` of its Voronoi cell, or the container's
  std::vector<std::vector<Partner>> partner;  // of each Voronoi cell
  std::vector<Index> cluster;                 // of each Voronoi cell; empty: all are one
};

/// Voronoi cells of all seeds, the same on any number of threads.
Tessellation voronoi(const TessellationSpace& space, std::vector<Vec3> seeds, Team& team);

/// Voronoi cells of given seeds, moved `rounds` times to their cells' centres. Throws InputError where one is outside
/// of the space, or where another is.
Tessellation relaxed_voronoi(const TessellationSpace& space, std::vector<Vec3> seeds, int rounds, Team& team);

/// `count` random seeds, moved `rounds` times to their Voronoi cells' centres (Lloyd); cells below a tenth of the mean
/// volume are merged away. Throws InputError where the space is too narrow.
Tessellation voronoi_packing(const TessellationSpace& space, std::size_t count, int rounds, std::uint64_t seed,
                             Team& team);

}  // namespace grus::dem
