// SPDX-License-Identifier: LGPL-3.0-or-later
// From near pairs to the columns of contacts: what a whole list and a mended one have in common.
#pragma once

#include <algorithm>

#include "dem/contact/mesh_pairs.hpp"
#include "dem/contact/near_pairs.hpp"
#include "dem/contact/neighbours.hpp"
#include "dem/contact/pair_kinds.hpp"

namespace grus::dem {

/// Contacts of the list before, where grains were split since: looked up by grain.
struct Past {
  const NeighbourRoom& old;
  const Contacts& lists;  // whose index of grains and bins are still those of before
  std::span<const Index> origin;

  Index before(Index i) const { return origin.empty() ? i : origin[i]; }

  /// Index in the old list, or `none`.
  Index find(Index a, Index b, std::array<std::int16_t, 3> image, bool wall) const {
    Index p = before(a), q = wall ? b : before(b);
    if (p == nobody || q == nobody || (!wall && p == q)) return none;  // new, or siblings
    if (!wall && p > q) {
      std::swap(p, q);
      for (auto& v : image) v = static_cast<std::int16_t>(-v);
    }
    if (static_cast<std::size_t>(p) + 1 >= lists.index.first.size()) return none;
    for (Index e = lists.index.first[p]; e < lists.index.first[p + 1]; ++e) {
      if (lists.index.entry[e] & 1) break;  // pairs of which p is a come first
      const Index k = lists.index.entry[e] >> 1;
      const Pair& pair = old.pair[k];
      if (pair.b == q && (k >= lists.begin[first_wall]) == wall && pair.image == image) return k;
    }
    return none;
  }

  static constexpr Index none = ~Index{0}, nobody = none;
};

/// What it takes to put pairs on the new list, a tile at a time. The list before is in the room, but for its histories,
/// which stay where they are until `lay_out`.
struct Lister {
  const Grains& grains;
  const Boundary& boundary;
  std::size_t materials;
  Past past;
  NeighbourRoom& room;
  double skin, wall_skin;
  bool shown;  // what spheres show is looked at in every step
  std::span<const Pair> bonded, walled;

  bool touched(Index old) const { return old != Past::none && past.lists.contact.touching(old); }
  std::uint16_t law(Index a, std::uint8_t other) const {
    return static_cast<std::uint16_t>(grains.material[a] * materials + other);
  }

  void put(std::size_t t, NeighbourRoom::Listed pair, const Vec3& normal) {
    if (pair_kind(pair.bin).near) {
      pair.normal = static_cast<Index>(room.listed_normal[t].size());
      room.listed_normal[t].push_back(normal);
    }
    room.listed[t].push_back(pair);
    ++room.counts[t][2 * static_cast<std::size_t>(pair.bin) + !touched(pair.old)];
  }

  /// Puts a candidate on the list if it is near. `find(bin, a, b, image)`: where its history is.
  template <class Find>
  void consider(std::size_t t, const Candidate& c, Find&& find) {
    if (!close(grains, boundary.cell, c, skin)) return;
    if (grains.motion[c.a].inverse_mass + grains.motion[c.b].inverse_mass == 0) return;  // both of rough walls
    if (!bonded.empty() && std::binary_search(bonded.begin(), bonded.end(), Pair{c.a, c.b, c.image}, by_place)) return;
    const Bin bin = pair_bin(grains.kind[c.a], grains.kind[c.b]);
    const auto near = pair_kind(bin).near;
    const NeighbourRoom::Listed pair{
        {c.a, c.b, c.image, law(c.a, grains.material[c.b])}, find(bin, c.a, c.b, c.image), bin};
    Vec3 normal = Vec3::Zero();
    if (near && !touched(pair.old)) {
      if (pair.old != Past::none)
        normal = past.before(c.a) > past.before(c.b) ? Vec3(-room.touch[pair.old].normal) : room.touch[pair.old].normal;
      if (!near(grains, boundary.cell, c, skin, normal)) return;
    }
    put(t, pair, normal);
  }

  /// Puts the walls that grain i is near on the list, but for those that `known` says are on it.
  template <class Find, class Known>
  void consider_walls(std::size_t t, Index i, Find&& find, Known&& known) {
    if (grains.motion[i].inverse_mass == 0) return;
    for (std::size_t w = 0; w < boundary.walls.size(); ++w) {
      const Wall& wall = boundary.walls[w];
      const Motion& g = grains.motion[i];
      if (wall.mesh()) {
        consider_triangles(t, i, static_cast<Index>(w), find, known);
        continue;
      }
      if (wall.distance(g.position) > g.radius + wall_skin) continue;
      if (!walled.empty() && std::binary_search(walled.begin(), walled.end(), Pair{i, static_cast<Index>(w)}, by_place))
        continue;
      const Bin bin = wall_bin(grains.kind[i], wall);
      const auto b = static_cast<Index>(w);
      if (!known(b, {})) put(t, {{i, b, {}, law(i, wall.material)}, find(bin, i, b, {}), bin}, Vec3::Zero());
    }
  }

  /// The same of the triangles of a wall that is a surface of them.
  template <class Find, class Known>
  void consider_triangles(std::size_t t, Index i, Index b, Find&& find, Known&& known) {
    const Wall& wall = boundary.walls[b];
    std::vector<Index>& near = room.near[t];
    triangles_near(*wall.mesh(), grains.motion[i].position - wall.point, grains.motion[i].radius + wall_skin, near);
    for (const Index triangle : near) {
      const auto image = image_of_triangle(triangle);
      if (!known(b, image))
        put(t, {{i, b, image, law(i, wall.material)}, find(sphere_mesh, i, b, image), sphere_mesh}, Vec3::Zero());
    }
  }
};

/// The pairs become the list before; with what they show, but for spheres that do not swell: nobody looks at that
/// before the next step that is observed.
void put_aside(const Grains& grains, Contacts& contacts, NeighbourReference& reference);

/// Empty lists for the tiles, which cost the same unless room.work, running sums, says otherwise.
void begin_tiles(std::size_t grains, NeighbourRoom& room);

/// Makes the columns of the contacts from what the tiles have on their lists. In each tile and bin, pairs that touch
/// come first.
void lay_out(const Lister& lister, Contacts& contacts, bool indexed, Team& team);

/// Pairs of up to one in so many grains are searched again alone: with more, a whole list costs hardly more.
inline constexpr std::size_t few_of = 32;

/// From here on the list counts: ways of all grains, or of `few` of them.
void begin_ways(const Grains& grains, const Boundary& boundary, double skin, NeighbourReference& reference, Team& team);
void begin_ways_of(std::span<const Index> few, const Grains& grains, const Boundary& boundary,
                   NeighbourReference& reference);

/// What the affine motion of a cell since `before` may take off the gap of pairs at the end of their reach.
double affine_loss(const Cell& cell, const Mat3& before, double reach);

/// The furthest that a wall has moved against its normal or along it since the list was made.
double wall_travel(const Boundary& boundary, const NeighbourReference& reference);

}  // namespace grus::dem
