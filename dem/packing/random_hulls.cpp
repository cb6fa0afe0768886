// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/random_hulls.hpp"

#include <algorithm>

#include "dem/shape/hull_store.hpp"

namespace grus::dem {
namespace {

/// Stretched, about its mass centre, with the volume of the unit sphere.
UnitHull unit_of(const Polyhedron& body, const Vec3& aspect) {
  UnitHull hull{body, 0};
  stretch(hull.body, aspect);
  const SolidMoments m = moments_of(hull.body);
  place(hull.body, Mat3::Identity(), -m.centre);
  stretch(hull.body, Vec3::Constant(std::cbrt(4 * pi / 3 / m.volume)));
  for (const Vec3& x : hull.body.vertex) hull.reach = std::max(hull.reach, x.norm());
  return hull;
}

}  // namespace

UnitHull ball_of_planes(const Vec3& aspect) {
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  Polyhedron body = box_between(Vec3::Constant(-2), Vec3::Constant(2));
  std::int64_t tag = 0;
  const auto along = [&](const Vec3& d) { cut(body, d.normalized(), 1, tag++, 1e-12); };
  for (const double s : {-1.0, 1.0})
    for (const double t : {-1.0, 1.0}) {
      for (int k = 0; k < 3; ++k) {
        Vec3 d = Vec3::Zero();
        d[(k + 1) % 3] = s, d[(k + 2) % 3] = t * golden;
        along(d);
        d[(k + 1) % 3] = s / golden, d[(k + 2) % 3] = t * golden;
        along(d);
      }
      for (const double u : {-1.0, 1.0}) along(Vec3(s, t, u));
    }
  return unit_of(body, aspect);
}

std::vector<UnitHull> random_hulls(int rounds, const Vec3& aspect, std::uint64_t seed, Team& team) {
  const TessellationSpace space = periodic_space(Vec3::Constant(std::cbrt(static_cast<double>(random_hull_shapes))));
  std::vector<UnitHull> hulls;
  for (const Polyhedron& cell : voronoi_packing(space, random_hull_shapes, rounds, seed, team).body) {
    if (cell.vertex.size() > most_hull_vertices || cell.face.size() > most_hull_faces) continue;
    hulls.push_back(unit_of(cell, aspect));
  }
  return hulls;
}

}  // namespace grus::dem
