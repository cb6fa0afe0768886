// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/cell_shape.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace grus::fem {
namespace {

/// Each corner and its neighbours, in right-handed order.
std::vector<std::array<int, 4>> corner_frames(CellKind kind) {
  switch (kind) {
    case CellKind::triangle:
      return {{0, 1, 2, -1}};
    case CellKind::tetrahedron:
      return {{0, 1, 2, 3}};
    case CellKind::quadrilateral:
      return {{0, 1, 3, -1}, {1, 2, 0, -1}, {2, 3, 1, -1}, {3, 0, 2, -1}};
    default:
      return {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7},
              {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}};
  }
}

Point edge(const Point& from, const Point& to) { return {to[0] - from[0], to[1] - from[1], to[2] - from[2]}; }
double length(const Point& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace

std::string cell_fault(CellKind kind, std::span<const Point> nodes) {
  int signs = 0, corners = 0;
  for (const auto& [at, i, j, k] : corner_frames(kind)) {
    const auto node = [&](int n) { return nodes[static_cast<std::size_t>(n)]; };
    const Point a = edge(node(at), node(i)), b = edge(node(at), node(j));
    const double z = a[0] * b[1] - a[1] * b[0];
    double volume = z, longest = std::max(length(a), length(b)), scale = longest * longest;
    if (k >= 0) {
      const Point c = edge(node(at), node(k));
      volume = z * c[2] + (a[1] * b[2] - a[2] * b[1]) * c[0] + (a[2] * b[0] - a[0] * b[2]) * c[1];
      longest = std::max(longest, length(c)), scale = longest * longest * longest;
    }
    if (!(std::abs(volume) > 1e-10 * scale)) return "is flat";
    signs += volume > 0 ? 1 : -1, ++corners;
  }
  return std::abs(signs) == corners ? "" : "is folded over itself";
}

}  // namespace grus::fem
