// SPDX-License-Identifier: LGPL-3.0-or-later
// The points that stand for a grain when peridynamics is asked whether it breaks: a cubic lattice in the grain's own
// frame, turned at random, and the forces of its contacts on them. All lengths are shares of the equivalent diameter.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "dem/kernel/lattice_pass.hpp"
#include "dem/shape/hull_store.hpp"

namespace grus::dem {

/// A convex solid in the frame of its mass centre. Planes: of a hull; none: a sphere.
struct LatticeSolid {
  std::span<const Plane> planes = {};
  double volume = 0;                            // m^3
  double least_width = 0, bounding_radius = 0;  // m

  /// Of the sphere of the same volume (m).
  double diameter() const { return std::cbrt(6 / pi * volume); }
};
LatticeSolid lattice_sphere(double radius);
LatticeSolid lattice_hull(const HullStore& store, Index hull);

/// How a grain is cut into points.
struct LatticeChoice {
  int points = 1000;           // about so many, whatever the shape
  double horizon = 2.5;        // spacings
  bool partial_volume = true;  // neighbours count less and less from half a spacing within the horizon to half beyond
  double patch = 0.124;        // a contact presses on what is so near, share of the diameter
  bool turned = true;          // at random; otherwise along the grain's axes
  static constexpr double layers = 3;  // a solid is at least so many spacings thick, even if that takes more points
  static constexpr double most_points = 8;  // but not more than so many times as many

  double spacing() const;  // of points so many, share of the diameter
};

/// A force that a grain bears on a part of its surface, in the grain's frame about its mass centre.
struct PatchLoad {
  Vec3 at;                     // m
  Vec3 force;                  // on the grain (N)
  Vec3 couple = Vec3::Zero();  // about `at` (N m)
  double area = 0;             // of contact (m^2): the patch is as large at least
};

/// Of what a contact presses on (m).
double patch_radius(const PatchLoad& load, double patch, double diameter);

/// A neighbour that a point with a whole family has.
struct LatticeNeighbour {
  int at[3];      // in spacings
  double length;  // spacings
  double weight;  // share of its volume that counts, above 0 and at most 1
};

/// Neighbours within a horizon (spacings), nearest first. With `partial_volume` the weight falls linearly from 1 at
/// half a spacing within the horizon to 0 at half a spacing beyond it.
std::vector<LatticeNeighbour> lattice_family(double horizon, bool partial_volume);

/// Points on the cells of a box with empty cells on all sides, so that no neighbour is looked up: it lies a fixed step
/// away. Points run in the order of their cells.
struct PointLattice {
  double spacing = 0, volume = 0;  // of a point: shares of the diameter and of its cube
  double nominal_spacing = 0;      // what the number of points asked for: more where the solid is thin
  std::vector<LatticeNeighbour> family;
  std::vector<LatticeWay> ways;  // the same for the kernel, lengths in shares of the diameter
  std::size_t cells = 0;
  std::vector<std::uint32_t> cell;  // of each point
  std::vector<Vec3> point;          // from the mass centre, in the grain's frame
  Mat3 axes = Mat3::Identity();     // of the lattice in the grain's frame
  std::vector<LatticeOctet> octet;  // and one more that ends them
  std::vector<std::uint16_t> way;  // of the octets' bonds, those that no point has left out: the neighbour, by `family`
  std::vector<std::uint8_t> bond;  // which of the eight points have it, bit by bit

  std::size_t size() const { return point.size(); }
};

/// The lattice of a solid; which way it is turned and where it begins is drawn by (seed, id). Points that hang on too
/// few others to stand still are left out. Empty where even a finer one has too few.
PointLattice make_lattice(const LatticeSolid& solid, const LatticeChoice& choice, std::uint64_t seed, std::uint64_t id);

/// Forces on the points (rows of three by point, axes of the lattice), evenly within each patch, the nearest four at
/// least, less what the grain's rigid acceleration takes (d'Alembert): they balance, forces and moments. Lengths:
/// shares of `diameter` (m).
std::vector<Vec3> point_forces(const PointLattice& lattice, std::span<const PatchLoad> loads, double patch,
                               double diameter);

/// Which points are no further from where any of the loads acts (m).
std::vector<bool> points_near(const PointLattice& lattice, std::span<const PatchLoad> loads, double distance);

}  // namespace grus::dem
