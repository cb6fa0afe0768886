// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/state/boundary.hpp"

namespace grus::dem {

namespace {

/// A third edge that no pair reaches across, whatever the skin, for a while as the walls part.
double edge_for(double height, double largest) { return 2 * height + 8 * largest; }

}  // namespace

Cell walled_cell(const Vec3& box, double largest) {
  Cell cell;
  cell.vectors = Mat3(Vec3(box.x(), box.y(), edge_for(box.z(), largest)).asDiagonal()), cell.walled = true;
  return cell;
}

bool heighten(Cell& cell, double height, double largest) {
  if (!cell.walled || cell.vectors(2, 2) >= 1.5 * height + 6 * largest) return false;
  cell.vectors(2, 2) = edge_for(height, largest);
  return true;
}

double Cell::height() const { return 1 / vectors.inverse().rowwise().norm().maxCoeff(); }

}  // namespace grus::dem
