// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/listing.hpp"

#include <algorithm>

#include "dem/base/renew.hpp"
#include "dem/contact/tiles.hpp"

namespace grus::dem {

void put_aside(const Grains& grains, Contacts& contacts, NeighbourReference& reference) {
  NeighbourRoom& room = reference.room;
  room.pair.swap(contacts.pair);
  room.guesses.row.swap(contacts.guesses.row), room.first_hulls = contacts.begin[hull_hull];
  if (!grains.frame.empty() || !reference.radius.empty()) room.touch.swap(contacts.touch);
}

void begin_tiles(std::size_t grains, NeighbourRoom& room) {
  const std::size_t tiles = tile_count(grains);
  room.listed.resize(std::max(room.listed.size(), tiles)), room.crossing.resize(std::max(room.crossing.size(), tiles));
  room.listed_normal.resize(room.listed.size());
  room.near.resize(room.listed.size());
  for (auto& listed : room.listed) listed.clear();
  for (auto& normal : room.listed_normal) normal.clear();
  for (auto& crossing : room.crossing) crossing.clear();
  room.counts.assign(tiles, {});
  room.work.clear();
}

namespace {

/// Turns the tiles' counts into the rows at which their pairs begin, bin by bin, and makes room for all.
void make_rows(std::size_t tiles, NeighbourRoom& room, Contacts& contacts) {
  // Contacts that leave the list while touching cannot exist: the skin exceeds any gap they could have opened.
  std::size_t total = 0;
  for (std::size_t bin = 0; bin < bin_count; ++bin) {
    contacts.begin[bin] = total;
    contacts.tile[bin].resize(tiles + 1), contacts.apart[bin].resize(tiles);
    for (std::size_t t = 0; t < tiles; ++t) {
      contacts.tile[bin][t] = static_cast<Index>(total);
      for (std::size_t h = 2 * bin; h < 2 * bin + 2; ++h) {
        const std::size_t pairs = room.counts[t][h];
        if (h & 1) contacts.apart[bin][t] = static_cast<Index>(total);
        room.counts[t][h] = static_cast<Index>(total), total += pairs;
      }
    }
    contacts.tile[bin][tiles] = static_cast<Index>(total);
  }
  contacts.begin[bin_count] = total;
  renew(contacts.pair, total);
  if (contacts.spots) contacts.spot.resize(total);
  contacts.guesses.row.resize(contacts.begin[hull_hull + 1] - contacts.begin[hull_hull]);
  renew(contacts.touch, total + overrun), renew(contacts.active, total + overrun);
  for (std::size_t k = total; k < total + overrun; ++k) contacts.touch[k] = {}, contacts.active[k] = 0;
  renew(room.source, total);
  make_room(total, contacts.plan);
  contacts.plan.tile_work.resize(tiles + 1);
}

/// Of the place of a pair on the list before: a and b have changed sides since.
constexpr Index sides_changed = Index{1} << 31;

/// Histories go to the places of the new list, column by column: no two lists of them stand there at once.
void move_histories(NeighbourRoom& room, ContactColumns& contact, Team& team) {
  const std::size_t total = room.source.size();
  for_each_contact_column(contact, [&](std::vector<double>& column) {
    renew(room.column, total + overrun);
    team.blocks(total, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const Index from = room.source[k];
        room.column[k] = from == Past::none ? 0 : column[from & ~sides_changed];
      }
    });
    std::fill(room.column.begin() + static_cast<std::ptrdiff_t>(total), room.column.end(), 0.0);
    column.swap(room.column);
  });
  for (std::size_t k = 0; k < total; ++k) {
    if (room.source[k] == Past::none || (room.source[k] & sides_changed) == 0) continue;
    for (std::size_t row = 0; row < spring_rows; ++row)
      if (const auto spring = static_cast<SpringRow>(row); contact.keeps[row])
        contact.set_force(spring, k, -contact.force(spring, k));
  }
}

}  // namespace

void lay_out(const Lister& lister, Contacts& contacts, bool indexed, Team& team) {
  NeighbourRoom& room = lister.room;
  const std::size_t grains = lister.grains.size(), tiles = tile_count(grains);
  make_rows(tiles, room, contacts);
  const int bits = tile_bits(grains);
  team.pieces(tiles, room.work, [&](std::size_t first, std::size_t last, int) {
    for (std::size_t t = first; t < last; ++t) {
      for (const auto& [pair, old, bin, normal] : room.listed[t]) {
        const bool on = lister.touched(old), wall = bin >= first_wall;
        const std::size_t k = room.counts[t][2 * static_cast<std::size_t>(bin) + !on]++;
        contacts.pair[k] = pair;
        contacts.active[k] = on;
        plan_pair(pair, k, t, wall, bits, contacts.plan, room.crossing[t]);
        const bool turned = !wall && lister.past.before(pair.a) > lister.past.before(pair.b);
        room.source[k] = on ? old | (turned ? sides_changed : 0) : Past::none;
        if (bin == hull_hull) {
          HullGuesses::Row& guess = contacts.guesses.row[k - contacts.begin[hull_hull]];
          const std::size_t before = old - room.first_hulls;
          if (on && !turned && before < room.guesses.row.size())
            guess = room.guesses.row[before];
          else
            guess.guess.octets = 0;
        }
        if (!lister.shown && !pair_kind(bin).shown_always) continue;  // what spheres show is of the last observed step
        Touch& touch = contacts.touch[k];
        touch = old != Past::none ? room.touch[old] : Touch{};
        if (turned) touch.normal = -touch.normal, touch.force = -touch.force;
        if (pair_kind(bin).near && !on) touch.normal = room.listed_normal[t][normal];
      }
      weigh_tile(lister.grains, t, contacts);
    }
  });
  const bool large = grains > large_sample;
  if (large) room.listed = {}, room.pair = {};
  move_histories(room, contacts.contact, team);
  if (large) room.source = {}, room.column = {};
  finish_plan(lister.grains, lister.boundary.cell, room.crossing, contacts, room.receivers, room.next);
  contacts.index.first.clear();
  if (indexed) index_grains(grains, contacts, room.next);
}

void index_grains(std::size_t grains, Contacts& contacts, std::vector<Index>& next) {
  contacts.index.first.assign(grains + 1, 0);
  const std::size_t walls = contacts.begin[first_wall];
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ++contacts.index.first[contacts.pair[k].a + 1];
    if (k < walls) ++contacts.index.first[contacts.pair[k].b + 1];
  }
  for (std::size_t i = 0; i < grains; ++i) contacts.index.first[i + 1] += contacts.index.first[i];
  contacts.index.entry.resize(contacts.index.first[grains]);
  next.assign(contacts.index.first.begin(), contacts.index.first.end() - 1);
  for (std::size_t k = 0; k < contacts.size(); ++k)
    contacts.index.entry[next[contacts.pair[k].a]++] = static_cast<Index>(2 * k);
  for (std::size_t k = 0; k < walls; ++k)
    contacts.index.entry[next[contacts.pair[k].b]++] = static_cast<Index>(2 * k + 1);
}

}  // namespace grus::dem
