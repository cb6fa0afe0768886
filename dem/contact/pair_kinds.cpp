// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/pair_kinds.hpp"

#include "dem/contact/hull_pairs.hpp"
#include "dem/contact/mesh_pairs.hpp"
#include "dem/contact/polyellipsoid_pairs.hpp"

namespace grus::dem {
namespace {

void spheres(const TileWork& work, std::size_t begin, std::size_t end) {
  run_rows(work, work.rows, sphere_pairs(), begin, end);
}

void spheres_at_walls(const TileWork& work, std::size_t begin, std::size_t end) {
  run_rows(work, work.rows, sphere_walls(), begin, end);
}

}  // namespace

void run_rows(const TileWork& work, const ContactRows& rows, PairLoop loop, std::size_t begin, std::size_t end) {
  const PassEnergy spent = loop(rows, begin, end);
  BlockEnergy& e = work.energy;
  e.friction += spent.friction;
  e.springs += spent.springs;
  e.viscous += spent.viscous;
  e.work -= rows.dt * spent.power;
}

const PairKind& pair_kind(std::size_t bin) {
  // By bin, in the order of the enumeration.
  static constexpr std::array<PairKind, bin_count> rows{{
      {.pass = spheres, .near = nullptr, .shown_always = false, .rolls = false, .touching = 15, .apart = 2},
      {.pass = polyellipsoids, .near = near, .shown_always = true, .rolls = true, .touching = 60, .apart = 12},
      {.pass = hulls, .near = hulls_near, .shown_always = true, .rolls = false, .touching = 2000, .apart = 100},
      {.pass = spheres_at_walls, .near = nullptr, .shown_always = false, .rolls = false, .touching = 15, .apart = 2},
      {.pass = polyellipsoids_at_walls,
       .near = nullptr,
       .shown_always = true,
       .rolls = true,
       .touching = 150,
       .apart = 2},
      {.pass = hulls_at_walls, .near = nullptr, .shown_always = true, .rolls = false, .touching = 1500, .apart = 30},
      {.pass = spheres_at_meshes, .near = nullptr, .shown_always = false, .rolls = false, .touching = 60, .apart = 30},
  }};
  return rows[bin];
}

Bin pair_bin(ShapeKind a, ShapeKind b) {
  if (a == ShapeKind::hull && b == ShapeKind::hull) return hull_hull;  // hulls meet nothing else: scenes refuse it
  return a == ShapeKind::sphere && b == ShapeKind::sphere ? sphere_sphere : general;
}

Bin wall_bin(ShapeKind kind, const Wall& wall) {
  if (wall.mesh()) return sphere_mesh;  // other shapes meet none: scenes refuse it
  static constexpr std::array<Bin, 3> rows{polyellipsoid_wall, sphere_wall, hull_wall};
  return rows[static_cast<std::size_t>(kind)];
}

}  // namespace grus::dem
