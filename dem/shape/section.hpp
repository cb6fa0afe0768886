// SPDX-License-Identifier: LGPL-3.0-or-later
// Where a plane cuts a hull, without making the pieces: no memory is asked for.
#pragma once

#include <array>

#include "dem/shape/hull_store.hpp"

namespace grus::dem {

/// A convex polygon in a plane with axes e1, e2 about a point; counter-clockwise seen against e1 x e2.
struct FlatPolygon {
  std::array<Eigen::Vector2d, most_hull_vertices + 8> corner;
  int corners = 0;

  void add(const Eigen::Vector2d& y) {
    if (corners < static_cast<int>(corner.size())) corner[static_cast<std::size_t>(corners++)] = y;
  }
};

/// Integrals over a polygon of 1, y and y y^T, y from the origin of its axes.
struct FlatMoments {
  double area = 0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();

  FlatMoments operator-(const FlatMoments& o) const { return {area - o.area, first - o.first, second - o.second}; }
};
FlatMoments moments_of(const FlatPolygon& polygon);

/// The part with along . y <= offset.
FlatPolygon clipped(const FlatPolygon& polygon, const Eigen::Vector2d& along, double offset);

/// The section of a hull by normal . x = offset (body frame), about the point offset * normal along `across(normal)`;
/// no corners: the plane misses the hull.
FlatPolygon section_of(const HullView& hull, const Vec3& normal, double offset);

/// Solid of a hull with normal . x >= offset (body frame), unit density.
SolidMoments part_beyond(const HullView& hull, const Vec3& normal, double offset);

/// As it is while it is made, tags: the faces' numbers.
Polyhedron body_of(const HullView& hull);

}  // namespace grus::dem
