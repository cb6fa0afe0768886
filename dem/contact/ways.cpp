// SPDX-License-Identifier: LGPL-3.0-or-later
// How far grains, walls and the cell have gone since the list of pairs was made, and how long it holds.
#include <algorithm>

#include "dem/contact/listing.hpp"

namespace grus::dem {
namespace {

/// From where the affine motion of the cell has taken the grains since the list was made, to where it was made.
Mat3 affine_since(const Cell& cell, const NeighbourReference& ref) {
  return cell.periodic() ? Mat3(cell.vectors * ref.cell.inverse()) : Mat3(Mat3::Identity());
}

}  // namespace

double affine_loss(const Cell& cell, const Mat3& before, double reach) {
  if (!cell.periodic()) return 0;
  return (cell.vectors * before.inverse() - Mat3::Identity()).norm() * reach;
}

double wall_travel(const Boundary& boundary, const NeighbourReference& reference) {
  double furthest = 0;
  for (std::size_t w = 0; w < boundary.walls.size(); ++w) {
    const Wall& wall = boundary.walls[w];
    const Vec3 moved = wall.point - reference.wall_point[w];
    furthest = std::max(furthest, std::visit([&](const auto& s) { return s.travel(moved); }, wall.shape));
  }
  return furthest;
}

ListState look_at_list(const Grains& grains, const Boundary& boundary, NeighbourReference& ref) {
  if (ref.stale) return ListState::stale;
  const double budget = ref.skin - 2 * ref.grown - affine_loss(boundary.cell, ref.cell, 2 * ref.largest + ref.skin);
  const double limit = std::min(0.5 * budget, budget - wall_travel(boundary, ref));
  if (limit <= 0) return ListState::stale;
  if (ref.travelled <= limit) return ListState::holds;  // not even the fastest, straight on
  const bool periodic = boundary.cell.periodic();
  const Mat3 affine = affine_since(boundary.cell, ref);
  auto& strays = ref.room.strays;
  strays.clear();
  double furthest = 0, furthest_other = 0;
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const Vec3 moved = grains.motion[i].position - (periodic ? Vec3(affine * ref.position[i]) : ref.position[i]);
    double path = moved.norm();
    // Chord of the quaternion difference is half the angle: surface points move by at most radius * angle.
    if (!ref.orientation.empty() && !is_sphere(grains, i)) {
      const auto &p = grains.orientation[i].coeffs(), &q = ref.orientation[i].coeffs();
      path += 2.01 * std::min((p - q).norm(), (p + q).norm()) * grains.motion[i].radius;
    }
    if (!ref.radius.empty()) path += grains.motion[i].radius - ref.radius[i];
    if (!(path < INFINITY)) return ListState::stale;
    furthest = std::max(furthest, path);
    if (path > 0.25 * limit)
      strays.push_back(static_cast<Index>(i));
    else
      furthest_other = std::max(furthest_other, path);
  }
  ref.travelled = furthest;
  if (furthest <= limit) return ListState::holds;
  // Half of what the list allowed at first must be left, or the next comes soon.
  if (strays.size() * few_of > grains.size() || limit < 0.25 * ref.skin) return ListState::stale;
  ref.travelled = furthest_other;
  return ListState::strays;
}

void begin_ways(const Grains& grains, const Boundary& boundary, double skin, NeighbourReference& ref, Team& team) {
  ++ref.builds;
  ref.stale = false;
  ref.skin = skin;
  ref.grown = 0;
  ref.travelled = 0;
  ref.mends = 0;
  ref.cell = boundary.cell.vectors;
  ref.position.resize(grains.size());
  ref.largest = 0;
  for (const auto& m : grains.motion) ref.largest = std::max(ref.largest, m.radius);
  team.blocks(grains.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) ref.position[i] = grains.motion[i].position;
  });
  if (!ref.radius.empty()) {
    ref.radius.resize(grains.size());
    for (std::size_t i = 0; i < grains.size(); ++i) ref.radius[i] = grains.motion[i].radius;
  }
  if (grains.frame.empty())
    ref.orientation.clear();
  else
    ref.orientation = grains.orientation;
  ref.wall_point.clear();
  for (const auto& wall : boundary.walls) ref.wall_point.push_back(wall.point);
}

void begin_ways_of(std::span<const Index> few, const Grains& grains, const Boundary& boundary,
                   NeighbourReference& ref) {
  const bool periodic = boundary.cell.periodic();
  const Mat3 back = affine_since(boundary.cell, ref).inverse();
  ++ref.mends;
  ref.position.resize(grains.size());
  if (!grains.frame.empty()) {
    if (ref.orientation.empty()) ref.orientation = grains.orientation;  // how the spheres stood does not matter
    ref.orientation.resize(grains.size());
  }
  if (!ref.radius.empty()) ref.radius.resize(grains.size());
  for (const Index i : few) {
    ref.position[i] = periodic ? Vec3(back * grains.motion[i].position) : grains.motion[i].position;
    if (!ref.orientation.empty()) ref.orientation[i] = grains.orientation[i];
    if (!ref.radius.empty()) ref.radius[i] = grains.motion[i].radius;
    ref.largest = std::max(ref.largest, grains.motion[i].radius);
  }
}

}  // namespace grus::dem
