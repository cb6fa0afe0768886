// SPDX-License-Identifier: LGPL-3.0-or-later
// Rigid walls - planes, cylinders about the grains, rollers - or the periodic cell.
#pragma once

#include <string>
#include <vector>

#include "dem/base/tensor.hpp"

namespace grus::dem {

struct Wall {
  Vec3 point, normal;  // unit normal into the space that grains may use; zero of a cylinder
  Vec3 velocity = Vec3::Zero();
  std::uint8_t material = 0;
  std::string name = {};
  Vec3 axis = Vec3::Zero();  // unit, of a cylinder about `point`, in which grains are
  double radius = 0;         // of a cylinder; 0: a plane
  double roller = 0;         // radius of a convex body about `axis` at `point`; 0: none
  std::uint32_t hull = 0;    // its shape

  bool round() const { return radius > 0; }
  /// How far x is on the good side (m).
  double distance(const Vec3& x) const {
    if (!round() && roller == 0) return normal.dot(x - point);
    const Vec3 from = x - point;
    const double away = (from - axis.dot(from) * axis).norm();
    return roller > 0 ? away - roller : radius - away;
  }
};

/// Columns of `vectors` are the cell's edges (m); they move at the constant `rate` (m/s), so that the affine field
/// x = vectors * s has no acceleration. Zero vectors: no cell, walls or open space. A cell that has been sheared far
/// is cut anew from the same lattice: `vectors` are then other edges than those that it began with.
struct Cell {
  Mat3 vectors = Mat3::Zero(), rate = Mat3::Zero();
  Mat3 whole = Mat3::Identity();  // whole numbers, det 1: vectors * whole are the edges that it began with

  bool periodic() const { return !vectors.col(0).isZero(0); }  // however the edges lie: any of them may have no x
  /// The edges that it began with, where they are now (m).
  Mat3 began() const { return whole.isIdentity(0) ? vectors : Mat3(vectors * whole); }
  /// Edges, or a rate of them, told of those that the cell began with, as of the present ones.
  Mat3 of_began(const Mat3& edges) const { return whole.isIdentity(0) ? edges : Mat3(edges * whole.inverse()); }
  double volume() const { return std::abs(vectors.determinant()); }
  double height() const;  // least distance between opposite faces (m)
};

struct Boundary {
  std::vector<Wall> walls;
  Cell cell;
};

/// The cylinder among the walls, if there is one.
inline const Wall* cylinder(const Boundary& boundary) {
  for (const Wall& wall : boundary.walls)
    if (wall.round()) return &wall;
  return nullptr;
}

}  // namespace grus::dem
