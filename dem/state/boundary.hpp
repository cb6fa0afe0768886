// SPDX-License-Identifier: LGPL-3.0-or-later
// Rigid walls - planes, cylinders about the grains, rollers - or the periodic cell.
#pragma once

#include <vector>

#include "dem/state/walls.hpp"

namespace grus::dem {

/// Columns of `vectors` are the cell's edges (m); they move at the constant `rate` (m/s), so that the affine field
/// x = vectors * s has no acceleration. Zero vectors: no cell, walls or open space. A cell that has been sheared far
/// is cut anew from the same lattice: `vectors` are then other edges than those that it began with.
struct Cell {
  Mat3 vectors = Mat3::Zero(), rate = Mat3::Zero();
  Mat3 whole = Mat3::Identity();  // whole numbers, det 1: vectors * whole are the edges that it began with
  bool walled = false;            // between walls along z: its third edge, beyond them, only keeps images away

  bool periodic() const { return !vectors.col(0).isZero(0); }  // however the edges lie: any of them may have no x
  bool everywhere() const { return periodic() && !walled; }
  /// The edges that it began with, where they are now (m).
  Mat3 began() const { return whole.isIdentity(0) ? vectors : Mat3(vectors * whole); }
  /// Edges, or a rate of them, told of those that the cell began with, as of the present ones.
  Mat3 of_began(const Mat3& edges) const { return whole.isIdentity(0) ? edges : Mat3(edges * whole.inverse()); }
  /// Velocity gradient of the affine field (1/s); zero without a cell.
  Mat3 gradient() const { return periodic() && !rate.isZero(0) ? Mat3(rate * vectors.inverse()) : Mat3(Mat3::Zero()); }
  double volume() const { return std::abs(vectors.determinant()); }
  double height() const;  // least distance between opposite faces (m)
};

/// A cell of this size along x and y, for walls that are a height apart and grains of at most this radius (m).
Cell walled_cell(const Vec3& box, double largest);

/// Whether grains within walls that are a height apart could meet images across them; then the third edge grows.
bool heighten(Cell& cell, double height, double largest);

struct Boundary {
  std::vector<Wall> walls;
  Cell cell;
};

/// The cylinder among the walls, if there is one.
inline const CylinderWall* cylinder(const Boundary& boundary) {
  for (const Wall& wall : boundary.walls)
    if (const auto* round = std::get_if<CylinderWall>(&wall.shape)) return round;
  return nullptr;
}

}  // namespace grus::dem
