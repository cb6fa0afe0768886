// SPDX-License-Identifier: LGPL-3.0-or-later
// Boxes of elements for tests that ask nothing of their boundaries, and their points.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "tests/fem/boundaries.hpp"

namespace grus::fem::test {

inline std::vector<std::size_t> all_of(const Problem& p) {
  std::vector<std::size_t> points(p.owned_points());
  std::iota(points.begin(), points.end(), 0);
  return points;
}

inline Problem box(const Point& size, std::array<long, 3> cells, Kinematics kinematics, bool brick = true,
                   ElementKind element = ElementKind::standard, int order = 1, int degree = 2,
                   std::function<Point(const Point&)> map = {}) {
  BoxMesh mesh;
  mesh.size = size, mesh.cells = cells, mesh.hexahedron = brick, mesh.map = std::move(map);
  return Problem(MPI_COMM_SELF, mesh, {order, degree, true, kinematics, 1, element}, {plane("base", 1, 0, 1, 0)});
}

/// Of two lists, over the largest number of the second.
inline double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0, size = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, std::abs(a[i] - b[i])), size = std::max(size, std::abs(b[i]));
  return most / size;
}

}  // namespace grus::fem::test
