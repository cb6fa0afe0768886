// SPDX-License-Identifier: LGPL-3.0-or-later
// Questions that rooms ask of a shape beyond its columns, by kind: a new kind is a row here.
#pragma once

#include "dem/state/grains.hpp"

namespace grus::dem {

/// Directions and points are global; frames must be up to date.
struct ShapeFunctions {
  /// Lever from the centre of mass to the surface point that lies furthest along the unit vector `outward` (m).
  Vec3 (*surface_arm)(const Grains& grains, std::size_t i, const Vec3& outward);
  /// Sum of the two principal radii of the surface where its normal is the unit vector `outward` (m).
  double (*sum_of_radii)(const Grains& grains, std::size_t i, const Vec3& outward);
  /// Widths along the axes of the shape, longest first (m).
  Vec3 (*sorted_widths)(const Grains& grains, std::size_t i);
  /// A point of the surface for each direction of the geometry frame (m): pictures are drawn with them. `frame`:
  /// frame_of.
  Vec3 (*drawn)(const Grains& grains, std::size_t i, const Frame& frame, const Vec3& direction);
  /// The cost of moving a grain, where a touching pair of spheres costs 15 (dealing tiles to threads).
  std::uint64_t cost;
};

const ShapeFunctions& shape_functions(ShapeKind kind);

inline Vec3 surface_arm(const Grains& g, std::size_t i, const Vec3& outward) {
  return shape_functions(g.kind[i]).surface_arm(g, i, outward);
}

inline double sum_of_radii(const Grains& g, std::size_t i, const Vec3& outward) {
  return shape_functions(g.kind[i]).sum_of_radii(g, i, outward);
}

inline Vec3 sorted_widths(const Grains& g, std::size_t i) { return shape_functions(g.kind[i]).sorted_widths(g, i); }

}  // namespace grus::dem
