// SPDX-License-Identifier: LGPL-3.0-or-later
// A list that a few grains have made useless is mended: grains that break, and strays that fly while all others creep.
#include <algorithm>

#include "dem/contact/listing.hpp"

namespace grus::dem {
namespace {

/// The pairs of a tile of the list before, grain by grain.
struct Rows {
  const std::vector<Pair>& pair;
  std::array<Index, 2 * bin_count> at{}, end{};

  Rows(const std::vector<Pair>& pairs, const Contacts& before, std::size_t t) : pair(pairs) {
    for (std::size_t bin = 0; bin < bin_count && t + 1 < before.tile[bin].size(); ++bin)
      at[2 * bin] = before.tile[bin][t], end[2 * bin] = at[2 * bin + 1] = before.apart[bin][t],
             end[2 * bin + 1] = before.tile[bin][t + 1];
  }

  /// Calls f(bin, k) for the pairs of grain a. Grains are asked for in ascending order.
  template <class F>
  void each(Index a, F&& f) {
    for (std::size_t h = 0; h < at.size(); ++h)
      for (; at[h] < end[h] && pair[at[h]].a == a; ++at[h]) f(static_cast<Bin>(h / 2), at[h]);
  }
};

bool same_pair(const Pair& p, const Candidate& c) { return p.b == c.b && p.image == c.image; }

/// A pair that the list lacks may be this far apart by now: what the others went, they may come back, and go on.
double reach_now(const Cell& cell, const NeighbourReference& reference) {
  const double loss = affine_loss(cell, reference.cell, 2 * reference.largest + reference.skin);
  const double squared_strains = cell.periodic() ? 1.1 : 1.0;
  return squared_strains * (reference.skin + reference.travelled + loss);
}

}  // namespace

void mend_contacts(const Grains& grains, const Boundary& boundary, double skin, std::size_t materials,
                   std::span<const Index> few, std::span<const Index> origin, Contacts& contacts,
                   NeighbourReference& reference, Team& team, bool indexed) {
  NeighbourRoom& room = reference.room;
  const std::size_t n = grains.size(), tiles = tile_count(n), size = tile_size(n), before = reference.position.size();
  const Cell& cell = boundary.cell;
  const double reach = reach_now(cell, reference);
  const bool fits = !cell.periodic() || cell.height() >= 2 * reference.largest + reach;
  if (few.size() * few_of > n || tile_size(before) != size || !fits) {
    build_contacts(grains, boundary, skin, materials, origin, contacts, reference, team, indexed);
    return;
  }
  room.marked.assign(n, 0);
  for (const Index i : few) room.marked[i] = 1;
  find_candidates_of(few, room.marked, grains, cell, reach, room.few, room.search, team);
  const bool split = !origin.empty();  // histories of halves are their parents'; strays keep what pairs they have
  if (split && contacts.index.first.empty()) index_grains(before, contacts, room.next);
  put_aside(grains, contacts, reference);
  begin_tiles(n, room);
  Lister lister{grains,
                boundary,
                materials,
                {room, contacts, origin},
                room,
                reach,
                reference.skin + wall_travel(boundary, reference),
                !reference.radius.empty(),
                reference.bonded,
                reference.walled};
  auto find = [&](Bin bin, Index a, Index b, const std::array<std::int16_t, 3>& image) {
    return split ? lister.past.find(a, b, image, bin >= first_wall) : Past::none;
  };
  auto gone = [&](Index i) { return split && room.marked[i]; };
  team.pieces(tiles, room.work, [&](std::size_t first, std::size_t last, int) {
    for (std::size_t t = first; t < last; ++t) {
      Rows rows(room.pair, contacts, t);
      auto& listed = room.listed[t];
      for (std::size_t i = t * size; i < std::min(n, (t + 1) * size); ++i) {
        const auto a = static_cast<Index>(i);
        const auto start = static_cast<std::ptrdiff_t>(listed.size());
        rows.each(a, [&](Bin bin, Index k) {
          const Pair& pair = room.pair[k];
          if (!gone(a) && (bin >= first_wall || !gone(pair.b)))
            lister.put(t, {pair, k, bin}, pair_kind(bin).near ? room.touch[k].normal : Vec3(Vec3::Zero()));
        });
        const auto kept = static_cast<std::ptrdiff_t>(listed.size());
        auto known = [&](auto&& is) { return std::any_of(listed.begin() + start, listed.begin() + kept, is); };
        for (std::size_t k = room.few.row[i]; k < room.few.row[i + 1]; ++k) {
          const Candidate& c = room.few.pair[k];
          if (!known([&](const auto& l) { return l.bin < first_wall && same_pair(l.pair, c); }))
            lister.consider(t, c, find);
        }
        if (room.marked[i])
          lister.consider_walls(t, a, find, [&](Index w, const std::array<std::int16_t, 3>& image) {
            return known([&](const auto& l) { return l.bin >= first_wall && l.pair.b == w && l.pair.image == image; });
          });
        std::sort(listed.begin() + start, listed.end(), [](const auto& p, const auto& q) {
          return p.pair.b != q.pair.b ? p.pair.b < q.pair.b : p.pair.image < q.pair.image;
        });
      }
    }
  });
  lay_out(lister, contacts, indexed, team);
  begin_ways_of(few, grains, boundary, reference);
}

}  // namespace grus::dem
