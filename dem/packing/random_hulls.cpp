// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/random_hulls.hpp"

#include <algorithm>

#include "dem/shape/hull_store.hpp"

namespace grus::dem {

std::vector<UnitHull> random_hulls(int rounds, const Vec3& aspect, std::uint64_t seed, Team& team) {
  const TessellationSpace space = periodic_space(Vec3::Constant(std::cbrt(static_cast<double>(random_hull_shapes))));
  std::vector<UnitHull> hulls;
  for (const Polyhedron& cell : voronoi_packing(space, random_hull_shapes, rounds, seed, team).body) {
    if (cell.vertex.size() > most_hull_vertices || cell.face.size() > most_hull_faces) continue;
    UnitHull hull{cell, 0};
    stretch(hull.body, aspect);
    const SolidMoments m = moments_of(hull.body);
    place(hull.body, Mat3::Identity(), -m.centre);
    stretch(hull.body, Vec3::Constant(std::cbrt(4 * pi / 3 / m.volume)));
    for (const Vec3& x : hull.body.vertex) hull.reach = std::max(hull.reach, x.norm());
    hulls.push_back(std::move(hull));
  }
  return hulls;
}

}  // namespace grus::dem
