// SPDX-License-Identifier: LGPL-3.0-or-later
// The open and the pressed part of a face, once its two sides no longer meet: the sides are planes, so the opening
// is linear over the face, and the line where it is zero parts the polygon. Exact for the polygon.
#pragma once

#include <span>

#include "dem/base/tensor.hpp"
#include "dem/shape/section.hpp"

namespace grus::dem {

/// The opening of a face, shift + slope . y at y from its middle (m); negative: pressed.
struct FaceOpening {
  double shift;
  Eigen::Vector2d slope;

  double at(const Eigen::Vector2d& y) const { return shift + slope.dot(y); }
};

/// Integrals over a part of the face of the opening (m^3) and of the opening times y (m^4).
struct OpeningSums {
  double sum = 0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();

  /// The sum of the opening's square (m^4).
  double square(const FaceOpening& o) const { return o.shift * sum + o.slope.dot(first); }
  OpeningSums operator-(const OpeningSums& o) const { return {sum - o.sum, first - o.first}; }
};

inline OpeningSums sums_over(const FaceOpening& o, const FlatMoments& part) {
  return {o.shift * part.area + o.slope.dot(part.first), o.shift * part.first + part.second * o.slope};
}

/// Area and moments of what is pressed, of a convex polygon (counter-clockwise).
FlatMoments pressed_part(const FaceOpening& o, std::span<const Eigen::Vector2d> corner);

/// The face's two parts. `whole`: its moments about its middle, which all of its corners surround.
struct FaceParts {
  FlatMoments pressed;
  OpeningSums of_pressed, of_open;
};
FaceParts parts_of(const FaceOpening& o, const FlatMoments& whole, std::span<const Eigen::Vector2d> corner);

}  // namespace grus::dem
