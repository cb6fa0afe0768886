// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/state/shape_kinds.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

Vec3 sphere_arm(const Grains& g, std::size_t i, const Vec3& outward) { return g.motion[i].radius * outward; }

namespace polyellipsoid {

Vec3 surface_arm(const Grains& g, std::size_t i, const Vec3& outward) {
  const Mat3& axes = g.frame[i].axes;
  return g.frame[i].origin + axes * support(g.shape[i], axes.transpose() * outward) - g.motion[i].position;
}

double sum_of_radii(const Grains& g, std::size_t i, const Vec3& outward) {
  return dem::sum_of_radii(g.shape[i], g.frame[i].axes.transpose() * outward);
}

Vec3 sorted_widths(const Grains& g, std::size_t i) {
  Vec3 w = g.shape[i].plus + g.shape[i].minus;
  std::sort(w.data(), w.data() + 3, std::greater<>());
  return w;
}

/// Scaling a sphere's points octant by octant keeps the seams.
Vec3 drawn(const Grains& g, std::size_t i, const Frame& frame, const Vec3& direction) {
  return frame.origin + frame.axes * octant_squares(g.shape[i], direction).cwiseSqrt().cwiseProduct(direction);
}

}  // namespace polyellipsoid

namespace hull {

HullView of(const Grains& g, std::size_t i) { return (*g.hulls)[g.hull[i]]; }

Vec3 surface_arm(const Grains& g, std::size_t i, const Vec3& outward) {
  const Mat3& axes = g.frame[i].axes;
  return axes * support(of(g, i), axes.transpose() * outward);
}

/// Flat faces and sharp edges: as blunt as its bounding sphere.
double sum_of_radii(const Grains& g, std::size_t i, const Vec3&) { return 2 * g.motion[i].radius; }

Vec3 sorted_widths(const Grains& g, std::size_t i) {
  Vec3 w;
  for (int k = 0; k < 3; ++k) w[k] = support(of(g, i), Vec3::Unit(k))[k] - support(of(g, i), -Vec3::Unit(k))[k];
  std::sort(w.data(), w.data() + 3, std::greater<>());
  return w;
}

/// Where a ray from the mass centre leaves it.
Vec3 drawn(const Grains& g, std::size_t i, const Frame& frame, const Vec3& direction) {
  const HullView hull = of(g, i);
  double reach = INFINITY;
  for (int f = 0; f < hull.faces; ++f)
    if (const double along = hull.plane[f].normal.dot(direction); along > 0)
      reach = std::min(reach, hull.plane[f].offset / along);
  return frame.origin + frame.axes * (reach * direction);
}

}  // namespace hull

}  // namespace

const ShapeFunctions& shape_functions(ShapeKind kind) {
  // Spheres are poly-ellipsoids of six equal semi-axes, but for what can be had without a frame.
  static constexpr ShapeFunctions rows[] = {
      {polyellipsoid::surface_arm, polyellipsoid::sum_of_radii, polyellipsoid::sorted_widths, polyellipsoid::drawn,
       150},
      {sphere_arm, polyellipsoid::sum_of_radii, polyellipsoid::sorted_widths, polyellipsoid::drawn, 6},
      {hull::surface_arm, hull::sum_of_radii, hull::sorted_widths, hull::drawn, 150},
  };
  return rows[static_cast<std::size_t>(kind)];
}

}  // namespace grus::dem
