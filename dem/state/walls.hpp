// SPDX-License-Identifier: LGPL-3.0-or-later
// Kinds of rigid walls, each a small struct that answers what is asked of every wall: a new one is a struct here and a
// name in WallShape. Who needs no more than a plane's normal asks `facing`, whatever the kind.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "dem/base/tensor.hpp"
#include "dem/shape/hull_store.hpp"
#include "dem/shape/triangles.hpp"

namespace grus::dem {

// Each kind tells: `distance`, how far a place, seen from the wall's point, is on the good side (m); `travel`, how much
// nearer to what it faces a shift of its own may bring it (m); `sound`, whether its numbers are those of a wall in a
// state of these hulls (null: none). Hulls meet it by an overload of contact/hull_pairs.cpp, spheres by rows of
// contact/forces.cpp.

struct PlaneWall {
  Vec3 normal = Vec3::Zero();  // unit, into the space that grains may use

  double distance(const Vec3& from) const { return normal.dot(from); }
  double travel(const Vec3& moved) const { return std::abs(normal.dot(moved)); }
  bool sound(const HullStore*) const { return normal.allFinite(); }
};

/// Grains are within; it moves along its axis alone.
struct CylinderWall {
  Vec3 axis = Vec3::Zero();  // unit, through the wall's point
  double radius = 0;         // m

  double distance(const Vec3& from) const { return radius - (from - axis.dot(from) * axis).norm(); }
  double travel(const Vec3&) const { return 0; }
  bool sound(const HullStore*) const { return axis.allFinite() && std::isfinite(radius) && radius > 0; }
};

/// A convex body about an axis, which hulls alone meet.
struct RollerWall {
  Vec3 axis = Vec3::Zero();  // unit, through the wall's point
  double radius = 0;         // m
  std::uint32_t hull = 0;    // its shape

  double distance(const Vec3& from) const { return (from - axis.dot(from) * axis).norm() - radius; }
  double travel(const Vec3& moved) const { return moved.norm(); }
  bool sound(const HullStore* hulls) const {
    return axis.allFinite() && std::isfinite(radius) && radius > 0 && hulls && hull < hulls->row.size();
  }
};

/// A surface of triangles about the wall's point, which spheres alone meet, from either side: see
/// contact/mesh_pairs.hpp. How far it is nobody asks of the whole of it.
struct MeshWall {
  std::shared_ptr<const Triangles> surface = {};

  double distance(const Vec3&) const { return 0; }
  double travel(const Vec3& way) const { return way.norm(); }
  bool sound(const HullStore*) const { return surface && sound_surface(*surface); }
};

using WallShape = std::variant<PlaneWall, CylinderWall, RollerWall, MeshWall>;

struct Wall {
  Vec3 point = Vec3::Zero();
  WallShape shape = {};
  Vec3 velocity = Vec3::Zero();
  std::uint8_t material = 0;
  std::string name = {};
  std::vector<std::uint8_t> grains = {};  // materials of grains that move with it; see rve/rough_walls.hpp

  const Triangles* mesh() const {
    const auto* of = std::get_if<MeshWall>(&shape);
    return of ? of->surface.get() : nullptr;
  }
  /// Normal of a plane; zero of all that has no single one.
  Vec3 facing() const {
    const auto* plane = std::get_if<PlaneWall>(&shape);
    return plane ? plane->normal : Vec3(Vec3::Zero());
  }
  /// How far x is on the good side (m).
  double distance(const Vec3& x) const {
    return std::visit([&](const auto& s) { return s.distance(x - point); }, shape);
  }
};

}  // namespace grus::dem
