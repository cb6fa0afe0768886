// SPDX-License-Identifier: LGPL-3.0-or-later
// Convex hulls as they run: in flat columns, one row a shape, never changed once they are there. Body frame: origin at
// the centre of mass, axes principal.
#pragma once

#include <vector>

#include "dem/shape/polyellipsoid.hpp"
#include "dem/shape/polyhedron.hpp"

namespace grus::dem {

inline constexpr int most_hull_vertices = 64, most_hull_faces = 40;

struct Plane {
  Vec3 normal;    // unit, outward
  double offset;  // normal . x (m)
};

constexpr int in_eights(int n) { return (n + 7) / 8 * 8; }

/// One hull, to look at.
struct HullView {
  const Vec3* vertex;
  const Plane* plane;
  const std::uint16_t* begin;  // of face f: loop[begin[f]] to loop[begin[f + 1]]
  const std::uint8_t* loop;    // vertices, counter-clockwise seen from outside
  int vertices, faces;
  // Once more as the kernel reads them (kernel/hull_overlap.hpp): x, y, z of the vertices, a column of `room` each,
  // then normals' x, y, z and offsets, a column of `space` each, both in whole eights; rows of 4 by edge, of 3 by
  // vertex.
  const double *column, *rows;  // rows: normal, offset by plane, as many as `space`; x, y, z, 0 by vertex
  const std::uint8_t* edge;
  const std::uint64_t* at;
  int room, space, edges;
};

/// A row of what follows from a hull's shape.
struct HullRow {
  std::uint32_t vertex, plane, begin, loop, column, edge;  // where its own begin
  std::uint32_t vertices, faces, edges;
  double volume;  // m^3
  double depth;   // 3 volume / surface: half the distance of two matching Voronoi cells' seeds (m)
  double bounding_radius, least_width;  // m
  PrincipalFrame principal;             // moments per unit mass; axes: the identity
};

struct HullStore {
  std::vector<Vec3> vertex;
  std::vector<Plane> plane;
  std::vector<std::uint16_t> begin;
  std::vector<std::uint8_t> loop;
  std::vector<double> column;      // vertices and planes once more: see HullView
  std::vector<std::uint8_t> edge;  // the same
  std::vector<std::uint64_t> at;   // the same
  std::vector<HullRow> row;

  HullView operator[](Index hull) const {
    const HullRow& r = row[hull];
    const int vertices = static_cast<int>(r.vertices), faces = static_cast<int>(r.faces);
    return {&vertex[r.vertex],
            &plane[r.plane],
            &begin[r.begin],
            &loop[r.loop],
            vertices,
            faces,
            &column[r.column],
            &column[r.column + static_cast<std::uint32_t>(3 * in_eights(vertices) + 4 * in_eights(faces))],
            &edge[r.edge],
            &at[std::size_t{3} * r.vertex],
            in_eights(vertices),
            in_eights(faces),
            static_cast<int>(r.edges)};
  }
};

/// What the vertices of a hull belong to, from its edges (kernel/hull_overlap.hpp).
std::vector<std::uint64_t> belongings(const std::uint8_t* edge, std::size_t edges, std::size_t vertices);

/// Where a hull's body frame is in the frame in which it was given: x = axes * x_body + origin.
struct HullPlace {
  Vec3 origin = Vec3::Zero();
  Quat axes = Quat::Identity();
};

/// Adds a hull and says where its body frame is. Throws InputError where it has too many vertices or faces.
Index add_hull(HullStore& store, const Polyhedron& body, HullPlace& place);

/// The rows that are wanted, in their order, and nothing of the others. `place`: by row where it has gone.
HullStore only(const HullStore& store, const std::vector<std::uint8_t>& wanted, std::vector<Index>& place);

/// The same for the body of a wall, which does not turn: as it stands, about its mass centre.
Index add_unturned(HullStore& store, const Polyhedron& body);

/// Furthest point along d (m), body frame.
inline Vec3 support(const HullView& hull, const Vec3& d) {
  int best = 0;
  double most = hull.vertex[0].dot(d);
  for (int v = 1; v < hull.vertices; ++v)
    if (const double x = hull.vertex[v].dot(d); x > most) most = x, best = v;
  return hull.vertex[best];
}

/// Least depth of x below the planes (m), negative outside; `plane`: the one it is least deep below.
inline double depth_below(const HullView& hull, const Vec3& x, int& plane) {
  double least = INFINITY;
  for (int f = 0; f < hull.faces; ++f)
    if (const double d = hull.plane[f].offset - hull.plane[f].normal.dot(x); d < least) least = d, plane = f;
  return least;
}

}  // namespace grus::dem
