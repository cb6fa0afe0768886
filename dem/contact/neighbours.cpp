// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/neighbours.hpp"

#include <algorithm>
#include <atomic>

#include "dem/base/renew.hpp"
#include "dem/contact/listing.hpp"

namespace grus::dem {
namespace {

/// Contacts of a tile of the list before, where grains are the same: both lists are sorted, so one walk finds all.
struct Walk {
  std::span<const Pair> old;
  std::array<Index, 2 * bin_count> at, end;

  Walk(std::span<const Pair> before, const std::array<std::vector<Index>, bin_count>& tile,
       const std::array<std::vector<Index>, bin_count>& apart, std::size_t t)
      : old(before) {
    for (std::size_t bin = 0; bin < bin_count; ++bin) {
      at[2 * bin] = tile[bin][t], end[2 * bin] = at[2 * bin + 1] = apart[bin][t], end[2 * bin + 1] = tile[bin][t + 1];
    }
  }

  /// Index in the old list, or Past::none. Pairs are asked for in ascending order.
  Index find(Bin bin, Index a, Index b, const std::array<std::int16_t, 3>& image) {
    for (std::size_t h = 2 * static_cast<std::size_t>(bin); h < 2 * static_cast<std::size_t>(bin) + 2; ++h) {
      Index& k = at[h];
      while (k < end[h] && before(old[k], a, b, image)) ++k;
      if (k < end[h] && old[k].a == a && old[k].b == b && old[k].image == image) return k;
    }
    return Past::none;
  }

  static bool before(const Pair& p, Index a, Index b, const std::array<std::int16_t, 3>& image) {
    if (p.a != a) return p.a < a;
    return p.b != b ? p.b < b : p.image < image;
  }
};

/// True while the candidates hold every pair within `skin`: no grain has gone or grown by what is left of the reserve.
bool candidates_hold(const Grains& grains, const Cell& cell, double skin, NeighbourRoom& room, Team& team) {
  const std::size_t n = grains.size();
  if (cell.periodic() != Cell{.vectors = room.cell}.periodic()) return false;
  const double budget = 0.5 * (room.skin - skin - affine_loss(cell, room.cell, 2 * room.largest + room.skin));
  if (!(budget > 0)) return false;
  const Mat3 affine = cell.periodic() ? Mat3(cell.vectors * room.cell.inverse()) : Mat3(Mat3::Identity());
  std::atomic<bool> hold{true};
  team.blocks(n, [&](std::size_t begin, std::size_t end) {
    bool all = true;
    for (std::size_t i = begin; i < end; ++i) {
      const Motion& m = grains.motion[i];
      const auto& [position, radius] = room.anchor[i];
      const double way = budget - std::max(0.0, m.radius - radius);
      all = all && way > 0 &&
            (m.position - (cell.periodic() ? Vec3(affine * position) : position)).squaredNorm() <= way * way;
    }
    if (!all) hold.store(false, std::memory_order_relaxed);
  });
  return hold;
}

/// Candidates are searched with a reserve beyond the skin where they can be expected to last, and serve as long as it
/// does.
void renew_candidates(const Grains& grains, const Cell& cell, double skin, bool lasting, NeighbourRoom& room,
                      Team& team) {
  if (lasting && candidates_hold(grains, cell, skin, room, team)) return;
  room.skin = lasting ? 2.5 * skin : skin;
  room.cell = cell.vectors, room.largest = 0;
  for (const Motion& m : grains.motion) room.largest = std::max(room.largest, m.radius);
  if (cell.periodic()) room.skin = std::max(skin, std::min(room.skin, cell.height() - 2 * room.largest));
  room.anchor.clear();  // should the search fail, nothing vouches for what it leaves
  if (grains.size() > large_sample) room.anchor = {};
  find_candidates(grains, cell, room.skin, room.candidates, room.search, team);
  room.anchor.reserve(grains.size());
  for (const Motion& m : grains.motion) room.anchor.push_back({m.position, m.radius});
}

/// Pairs of a tile on the list that stands.
std::size_t listed_before(const Contacts& contacts, std::size_t tile) {
  std::size_t count = 0;
  for (const auto& of_bin : contacts.tile) count += of_bin[tile + 1] - of_bin[tile];
  return count;
}

}  // namespace

void build_contacts(const Grains& grains, const Boundary& boundary, double skin, std::size_t materials,
                    std::span<const Index> origin, Contacts& contacts, NeighbourReference& reference, Team& team,
                    bool indexed) {
  NeighbourRoom& room = reference.room;
  // Not the first, which nobody knows yet to last; not where grains break, or the list was mended because some go far.
  const bool lasting = origin.empty() && reference.mends == 0 && room.anchor.size() == grains.size();
  const std::size_t n = grains.size(), tiles = tile_count(n), size = tile_size(n);
  const bool same = origin.empty() && reference.position.size() == n && contacts.tile[0].size() == tiles + 1;
  const bool lean = same && n > large_sample;  // here a run needs the most: no more stands there than has to
  if (lean) contacts.index = {};
  renew_candidates(grains, boundary.cell, skin, lasting, room, team);
  if (!same && contacts.index.first.empty()) index_grains(reference.position.size(), contacts, room.next);
  put_aside(grains, contacts, reference);
  const auto& candidate = room.candidates.pair;
  const auto& row = room.candidates.row;
  begin_tiles(n, room);
  room.work.resize(tiles + 1);
  for (std::size_t t = 0; t <= tiles; ++t) room.work[t] = row[std::min(n, t * size)];
  if (lean)
    for (std::size_t t = 0; t < tiles; ++t) room.listed[t].reserve(with_reserve(listed_before(contacts, t)));
  Lister lister{grains,
                boundary,
                materials,
                {room, contacts, origin},
                room,
                skin,
                skin,
                !reference.radius.empty(),
                reference.bonded,
                reference.walled};
  auto list = [&](std::size_t first, std::size_t last, auto&& finder) {
    for (std::size_t t = first; t < last; ++t) {
      const std::size_t begin = t * size, end = std::min(n, begin + size);
      auto find = finder(t);
      for (std::size_t k = row[begin]; k < row[end]; ++k) lister.consider(t, candidate[k], find);
      for (std::size_t i = begin; i < end; ++i)
        lister.consider_walls(t, static_cast<Index>(i), find,
                              [](Index, const std::array<std::int16_t, 3>&) { return false; });
    }
  };
  team.pieces(tiles, room.work, [&](std::size_t first, std::size_t last, int) {
    if (same)
      list(first, last, [&](std::size_t t) {
        return [walk = Walk(room.pair, contacts.tile, contacts.apart, t)](
                   Bin bin, Index a, Index b, const std::array<std::int16_t, 3>& image) mutable {
          return walk.find(bin, a, b, image);
        };
      });
    else
      list(first, last, [&](std::size_t) {
        return [&](Bin bin, Index a, Index b, const std::array<std::int16_t, 3>& image) {
          return lister.past.find(a, b, image, bin >= first_wall);
        };
      });
  });
  lay_out(lister, contacts, indexed, team);
  begin_ways(grains, boundary, skin, reference, team);
}

}  // namespace grus::dem
