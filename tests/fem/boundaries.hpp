// SPDX-License-Identifier: LGPL-3.0-or-later
// Boundary conditions that the finite-element tests share.
#pragma once

#include <cmath>

#include "fem/problem.hpp"

namespace grus::fem::test {

/// One component prescribed on the plane x[axis] = place.
inline BoundaryCondition plane(std::string name, std::size_t axis, double place, std::size_t component, double value) {
  BoundaryCondition b;
  b.name = std::move(name);
  b.where = [=](const Point& x) { return std::abs(x[axis] - place) < 1e-9; };
  b.displacement[component] = value;
  return b;
}

}  // namespace grus::fem::test
