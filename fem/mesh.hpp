// SPDX-License-Identifier: LGPL-3.0-or-later
// Sources of a mesh: a box or rectangle, or a Gmsh file with tags.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace grus::fem {

using Point = std::array<double, 3>;

enum class CellKind { triangle, quadrilateral, tetrahedron, hexahedron };

inline int dimension(CellKind k) { return k == CellKind::triangle || k == CellKind::quadrilateral ? 2 : 3; }
inline bool bricks(CellKind k) { return k == CellKind::quadrilateral || k == CellKind::hexahedron; }
inline int corners(CellKind k) { return bricks(k) ? 1 << dimension(k) : dimension(k) + 1; }

/// A box from the origin; in two dimensions a rectangle, and the third entries are not read.
struct BoxMesh {
  Point size{1, 1, 1};  // m
  std::array<long, 3> cells{1, 1, 1};
  bool hexahedron = true;  // quadrilaterals in 2D; false: tetrahedra, triangles
  std::function<Point(const Point&)>
      map;  // moves nodes before anything is built (distorted meshes of tests); may be empty
  std::vector<std::int32_t> owner = {};  // rank of each element; empty: DOLFINx cuts the mesh
};

/// A first-order Gmsh mesh. Elements are those of the highest dimension, all of one kind, nodes in Gmsh's order.
struct MshMesh {
  CellKind kind = CellKind::hexahedron;
  std::vector<Point> nodes;                                         // m
  std::vector<std::int64_t> cells;                                  // corners(kind) an element, indices of nodes
  std::vector<int> cell_tags;                                       // physical group of each element; 0: none
  std::map<std::vector<std::int64_t>, std::vector<int>> facets;     // sorted corners -> physical groups
  std::map<std::string, std::vector<int>> facet_names, cell_names;  // physical groups of each name: one, or several
  std::map<int, std::string> idle_facets;  // of a group: those that bound no element from outside
  std::vector<std::string> notes;          // what a user should know of it, one line each
  std::vector<std::int32_t> owner = {};    // rank of each element; empty: DOLFINx cuts the mesh
};

/// Reads an ASCII .msh file, format 2.2 or 4.1. Throws std::invalid_argument, one line, with what is wrong where.
MshMesh read_msh(const std::string& path);

}  // namespace grus::fem
