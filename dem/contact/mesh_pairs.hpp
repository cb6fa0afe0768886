// SPDX-License-Identifier: LGPL-3.0-or-later
// Spheres at surfaces of triangles: a row of the table of pairs. Each triangle near a sphere is a pair, told by a
// number in the place of the image.
#pragma once

#include "dem/contact/pair_kinds.hpp"

namespace grus::dem {

/// Angle within which contacts of a sphere with one surface are one: the nearest alone presses. So a surface of many
/// triangles is as stiff as the round one that it stands for, and the far side of a sheet is not felt.
inline constexpr double one_surface = 0.2618;  // rad, 15 degrees

/// The number of a triangle as a pair keeps it; in their order.
inline std::array<std::int16_t, 3> image_of_triangle(Index t) {
  return {static_cast<std::int16_t>(t >> 15u), static_cast<std::int16_t>(t & 0x7fffu), 0};
}
inline Index triangle_of(const Pair& p) {
  return static_cast<Index>(p.image[0]) << 15u | static_cast<Index>(p.image[1]);
}

/// The pass; see PairKind. A triangle presses where it touches, unless another one of the surface is nearer and either
/// holds the place where it touches (at a shared edge or corner there is one contact) or lies in the same direction.
/// Which triangle presses may change as the sphere goes on: the contact goes on with it.
void spheres_at_meshes(const TileWork& work, std::size_t begin, std::size_t end);

/// The planes that the kernels see in the place of triangles: room for those of all such pairs.
void make_mesh_room(Contacts& contacts);

}  // namespace grus::dem
