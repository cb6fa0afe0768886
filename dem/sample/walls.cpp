// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/walls.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/rve/rough_walls.hpp"
#include "dem/state/shape_kinds.hpp"

namespace grus::dem {
namespace {

/// The last wall against those before it and against the grains: each would press on what is behind it.
void check_wall(const OwnWall& own, const std::vector<Wall>& walls, const Grains& g, bool grains_too) {
  const Wall& last = walls.back();
  const Vec3 facing = last.facing();
  if (facing.isZero(0)) return;
  double size = 0;
  for (const auto& extent : g.extent) size = std::max(size, extent.equivalent_radius);
  for (std::size_t k = 0; k + 1 < walls.size(); ++k) {
    const double along = walls[k].facing().dot(facing), ahead = facing.dot(walls[k].point - last.point);
    if (along > 1 - 1e-9 && std::abs(ahead) <= 1e-9 * size)
      refuse(own.place,
             fmt::format("this wall is where wall {} is: together they would be twice as stiff; leave one out", k));
    if (along < -1 + 1e-9 && ahead < 0)
      refuse(own.place_of_normal,
             fmt::format("no place is on the inner side of both this wall and wall {}: turn one of them", k));
  }
  for (std::size_t i = 0; grains_too && i < g.size(); ++i)
    if (facing.dot(g.motion[i].position - last.point) < 0)
      refuse(own.place_of_normal,
             fmt::format("grain {} is behind this wall: its normal points to where grains may be", i));
}

/// A plane across an axis, at the origin, that faces along it, or against.
Wall plate(int axis, bool against) {
  PlaneWall plane;
  plane.normal[axis] = against ? -1 : 1;
  return {.shape = plane};
}

void put_box(const Vec3& box, std::uint8_t material, Boundary& boundary) {
  for (int k = 0; k < 3; ++k)
    for (int side = 0; side < 2; ++side) {
      Wall wall = plate(k, side);
      if (side) wall.point[k] = box[k];
      wall.material = material;
      wall.name = fmt::format("{}{}", "xyz"[k], side ? "max" : "min");
      boundary.walls.push_back(wall);
    }
}

/// Two plates across z.
void put_plates(const Vec3& box, std::uint8_t material, Boundary& boundary) {
  for (int side = 0; side < 2; ++side)
    boundary.walls.push_back({.point = Vec3(0, 0, side ? box[2] : 0),
                              .shape = PlaneWall{Vec3(0, 0, side ? -1 : 1)},
                              .material = material,
                              .name = side ? "zmax" : "zmin"});
}

/// Two plates, and a cylinder of the box's width about its middle.
void put_cylinder(const Vec3& box, std::uint8_t material, Boundary& boundary) {
  put_plates(box, material, boundary);
  boundary.walls.push_back({.point = Vec3(0.5 * box[0], 0.5 * box[0], 0),
                            .shape = CylinderWall{Vec3::UnitZ(), 0.5 * box[0]},
                            .material = material,
                            .name = "cylinder"});
}

/// Section that platens press on; of a disc across its axis pi D t / 2, which makes it the tension in its middle.
double nominal_area(const Vec3& box, bool round, int axis) {
  if (!round) return box.prod() / box[axis];
  return axis == 2 ? 0.25 * pi * box.x() * box.x() : 0.5 * pi * box.x() * box.z();
}

}  // namespace

void put_own_walls(const Recipe& recipe, Sample& sample) {
  for (const OwnWall& own : recipe.walls) {
    sample.state.boundary.walls.push_back(own.wall);
    check_wall(own, sample.state.boundary.walls, sample.state.grains, !recipe.random());
  }
}

void put_bounds(const Recipe& recipe, Boundary& boundary) {
  if (recipe.bounds == Bounds::walls) put_box(recipe.box, recipe.wall_material, boundary);
  if (recipe.bounds == Bounds::periodic_xy) put_plates(recipe.box, recipe.wall_material, boundary);
  if (recipe.bounds == Bounds::cylinder) put_cylinder(recipe.box, recipe.wall_material, boundary);
  for (const Side& side : recipe.sides)
    for (Wall& wall : boundary.walls)
      if (wall.name == side.name) wall.velocity = side.velocity, wall.material = side.material.value_or(wall.material);
}

void fix_grains(const Recipe& recipe, Sample& sample) {
  Grains& g = sample.state.grains;
  std::size_t all = 0;
  for (const RoughWall& layer : recipe.rough) {
    Wall& wall = sample.state.boundary.walls[layer.wall];
    std::size_t count = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
      if (g.motion[i].inverse_mass == 0 || g.material[i] != layer.of.value_or(g.material[i])) continue;
      if (wall.distance(g.motion[i].position) > layer.within) continue;
      const std::uint8_t material = g.material[i] = layer.becomes[g.material[i]];
      if (!moves_with(wall, material)) wall.grains.push_back(material);
      fix(g, i, wall.velocity);
      ++count;
    }
    if (count == 0) refuse(layer.place, "no grain is there to move with this wall");
    all += count;
    if (all == g.size()) refuse(layer.place, "all grains move with walls: none is left free");
    sample.notes.push_back(fmt::format("{} of {} grains move with the wall {}", count, g.size(),
                                       wall.name.empty() ? fmt::format("{}", layer.wall) : wall.name));
  }
}

void put_platens(const Platens& platens, double low, double high, Boundary& boundary) {
  for (int side = 0; side < 2; ++side) {
    Wall wall = plate(platens.axis, side);
    wall.point[platens.axis] = side ? high : low;
    if (side) wall.velocity[platens.axis] = -(platens.by_speed ? platens.pace : (high - low) * platens.pace);
    wall.material = platens.material;
    wall.name = side ? "top" : "bottom";
    boundary.walls.push_back(wall);
  }
}

void put_platens(const Platens& platens, const Recipe& recipe, Sample& sample) {
  const Grains& g = sample.state.grains;
  const int axis = platens.axis;
  double low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < g.size(); ++i) {
    const Vec3 up = Vec3::Unit(axis);
    const double x = g.motion[i].position[axis];
    high = std::max(high, x + surface_arm(g, i, up)[axis]);
    low = std::min(low, x + surface_arm(g, i, -up)[axis]);
  }
  put_platens(platens, low, high, sample.state.boundary);
  if (recipe.of_voronoi() || sample.bonded())
    sample.gauge = Gauge{
        {{0, 0.5}, {1, -0.5}}, -Vec3::Unit(axis), 1, 1 / nominal_area(voronoi_box(recipe), is_round(recipe), axis)};
}

}  // namespace grus::dem
