// SPDX-License-Identifier: LGPL-3.0-or-later
// Convex polyhedra while they are made: cut by planes, hulls of points, masses. What runs is in hull_store.hpp.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "dem/base/tensor.hpp"

namespace grus::dem {

struct Polyhedron {
  struct Face {
    Vec3 normal;            // unit, outward
    double offset;          // normal . x of the face (m)
    std::int64_t tag;       // whatever the maker wants to know it by
    std::vector<int> loop;  // vertices, counter-clockwise seen from outside
  };
  std::vector<Vec3> vertex;
  std::vector<Face> face;

  bool empty() const { return face.empty(); }
};

/// Unit vectors across a unit vector, right-handed: e1 x e2 = n.
std::array<Vec3, 2> across(const Vec3& n);

/// Faces in the order -x, +x, -y, +y, -z, +z, tagged -1 to -6.
Polyhedron box_between(const Vec3& low, const Vec3& high);

/// A prism along z over a convex polygon (corners counter-clockwise seen from +z) between two heights. Sides are tagged
/// -1 onwards by corner, then bottom and top.
Polyhedron prism_over(std::span<const Vec3> corners, double low, double high);

/// Convex hull of up to 64 points, those inside it, its faces or its edges left out. Throws InputError where they lie
/// in a plane, or are too many.
Polyhedron hull_of(std::span<const Vec3> points);

/// Takes away what lies beyond normal . x = offset (unit normal); the fresh face gets `tag`. Points within `tolerance`
/// (m) count as in the plane. False: nothing is beyond. What is wholly beyond leaves an empty polyhedron.
bool cut(Polyhedron& body, const Vec3& normal, double offset, std::int64_t tag, double tolerance);

/// Moments of a solid of unit density.
struct SolidMoments {
  double volume = 0;           // m^3
  Vec3 centre = Vec3::Zero();  // m
  Mat3 second = Mat3::Zero();  // of (x - c)(x - c)^T (m^5)
};
SolidMoments moments_of(const Polyhedron& body);

/// Moments of a face.
struct FaceMoments {
  double area = 0;             // m^2
  Vec3 centre = Vec3::Zero();  // m
  Mat3 second = Mat3::Zero();  // of (x - c)(x - c)^T (m^4)
};
FaceMoments moments_of(const Polyhedron& body, const Polyhedron::Face& face);

/// The least distance of two parallel planes, one of a face, that hold the body between them (m).
double least_width(const Polyhedron& body);

/// Moves the whole: x -> r x + shift.
void place(Polyhedron& body, const Mat3& r, const Vec3& shift);

/// Makes it longer along x, y and z by factors above 0.
void stretch(Polyhedron& body, const Vec3& factors);

}  // namespace grus::dem
