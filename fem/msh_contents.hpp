// SPDX-License-Identifier: LGPL-3.0-or-later
// The contents of a .msh file, as its sections say them, in whatever order they come.
#pragma once

#include <stdexcept>

#include "fem/mesh.hpp"

namespace grus::fem {

struct ElementType {
  int code, dimension, nodes;
  const char* name;
};

struct MshElement {
  const ElementType* type;
  long long number;
  int tag, entity;               // its physical group (format 2.2), or the entity that is in some (4.1); 0: none
  std::vector<long long> nodes;  // numbers of the file
};

struct MshContents {
  std::string path;
  std::vector<long long> number;  // of the nodes
  std::vector<Point> node;
  std::map<long long, std::int64_t> index;  // of each number
  std::vector<MshElement> element;
  std::map<std::pair<int, std::string>, std::vector<int>> names;  // dimension and name -> physical groups
  std::map<std::pair<int, int>, std::vector<int>> groups;         // dimension and entity -> physical groups
};

/// A side of an element: its corners, sorted, -1 where it has fewer than four.
struct CellSide {
  std::array<std::int64_t, 4> corner{-1, -1, -1, -1};
  std::size_t cell = 0;
};

/// The sides of all elements, sorted by their corners: a side that two elements share stands twice.
std::vector<CellSide> sides_of(const MshMesh& mesh);

/// Throws std::invalid_argument for what is no mesh.
MshMesh mesh_of(const MshContents& contents);

/// Where the mesh is not one body: parts, nodes in one place, nodes on the sides of elements that do not have them.
/// `number`: what the file calls the mesh's nodes.
std::vector<std::string> openings(const MshMesh& mesh, const std::vector<CellSide>& sides,
                                  const std::vector<long long>& number);

}  // namespace grus::fem
