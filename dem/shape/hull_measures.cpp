// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/hull_measures.hpp"

namespace grus::dem {

double sphericity(const HullRow& row) {
  return std::cbrt(36 * pi * row.volume * row.volume) * row.depth / (3 * row.volume);
}

double angularity(const HullView& hull) {
  double sum = 0, length = 0, nearest = INFINITY;
  for (int f = 0; f < hull.faces; ++f) nearest = std::min(nearest, hull.plane[f].offset);
  for (int e = 0; e < hull.edges; ++e) {
    const std::uint8_t* edge = hull.edge + 4 * e;  // two corners, two faces
    const Vec3 &from = hull.vertex[edge[0]], &to = hull.vertex[edge[1]];
    const double l = (to - from).norm(), out = 0.5 * (from + to).norm() / nearest;
    const Vec3 &left = hull.plane[edge[2]].normal, &right = hull.plane[edge[3]].normal;
    sum += l * out * std::atan2(left.cross(right).norm(), left.dot(right)), length += l;
  }
  return sum / length;
}

}  // namespace grus::dem
