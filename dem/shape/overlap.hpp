// SPDX-License-Identifier: LGPL-3.0-or-later
// The forces of two convex hulls on each other where they overlap. K = A and B; x_c its centre; i, j the planes of A
// and B below which x_c is least deep; phi = depth below i + depth below j. The potential is U = c V phi(x_c) / 2, the
// foundation's modulus c in Pa/m: force and moment are its exact gradient, so nothing is lost; two parallel faces feel
// c A overlap, and resist rocking by c I.
#pragma once

#include "dem/shape/hull_store.hpp"

namespace grus::dem {

/// For c = 1; everything in the frame of A, of B's pose x = turn * x_b + shift.
struct Overlap {
  double volume = 0;           // m^3; 0: apart
  double energy = 0;           // V phi(x_c) / 2 (m^4)
  Vec3 force = Vec3::Zero();   // on B (m^3); -force on A, at the same point
  Vec3 moment = Vec3::Zero();  // on B about the origin of A (m^4)
  Vec3 area = Vec3::Zero();    // of A's surface within B, outward: c times its norm is the normal stiffness (m^2)
  Vec3 middle = Vec3::Zero();  // of that area: does not move as the bodies rock on each other (m)
  double polar = 0;            // of A's surface within B about the middle: integral of |x - middle|^2 (m^4)
  bool parted = false;         // already along `search`
  double gap = 0;              // of parted hulls, along it (m)
};

/// Points within this share of the hulls' size lie in a plane. Faces of A and B in one plane: B counts as the larger by
/// so much, so that such a face is told once.
inline constexpr double flush_share = 1e-12;

/// A guess of what an overlap is made of holds where round-off cannot have a say: by this share of the hulls' size.
inline constexpr double clear_share = 1e-8;

/// Bodies press from a mean depth (volume over area) of so many flush distances on: where the middle of a thinner
/// overlap lies, round-off says.
inline constexpr double thin = 16;

/// By the polygons of the faces, clipped one by one: the measure of the kernel for it (contact/hull_overlaps.hpp).
/// `search`: a unit vector from A to B, as good as is known; it decides what is looked at, not what is found.
Overlap overlap_by_faces(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, const Vec3& search);

/// A half space, normal . x <= offset in the frame of A, takes the place of B; `radius` bounds A from its origin (m).
Overlap overlap_with_plane(const HullView& a, const Plane& wall, double radius);

}  // namespace grus::dem
