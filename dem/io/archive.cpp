// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/io/archive.hpp"

#include <algorithm>
#include <limits>

#include "dem/contact/neighbours.hpp"
#include "dem/contact/tiles.hpp"

namespace grus::dem {
namespace {

void need(bool good, const char* what) {
  if (!good) throw InputError(std::string("checkpoint is damaged: ") + what);
}

/// Bins, tiles and pairs are what they must be for a plan to follow from them.
void check_list(const State& s) {
  const Contacts& c = s.contacts;
  const std::size_t n = s.grains.size(), walls = s.boundary.walls.size(), tiles = tile_count(n), total = c.size();
  const int bits = tile_bits(n);
  need(n > 0 && n < std::numeric_limits<Index>::max() / 2 && s.grains.kind.size() == n, "number of grains");
  for (const ShapeKind kind : s.grains.kind) need(kind <= ShapeKind::hull, "kind of a grain");
  need(std::is_sorted(c.begin.begin(), c.begin.end()) && c.begin.front() == 0 && c.begin.back() == total &&
           total < (std::size_t{1} << 31),
       "bins of the list");
  for (std::size_t bin = 0; bin < bin_count; ++bin) {
    const auto& tile = c.tile[bin];
    need(tile.size() == tiles + 1 && c.apart[bin].size() == tiles && std::is_sorted(tile.begin(), tile.end()) &&
             tile.front() == c.begin[bin] && tile.back() == c.begin[bin + 1],
         "tiles of the list");
    for (std::size_t t = 0; t < tiles; ++t) {
      need(tile[t] <= c.apart[bin][t] && c.apart[bin][t] <= tile[t + 1], "tiles of the list");
      for (std::size_t k = tile[t]; k < tile[t + 1]; ++k) {
        const Pair& p = c.pair[k];
        need(p.a < n && p.a >> bits == t && p.b < (bin < first_wall ? n : walls) && (bin >= first_wall || p.a < p.b),
             "a pair of the list");
      }
    }
  }
}

}  // namespace

std::uint64_t layout_of_states() {
  Layout layout;
  const State any;
  walk(layout, any);
  return layout.number();
}

std::string bytes_of(const State& state) {
  Saver saver;
  walk(saver, state);
  return saver.take();
}

State state_of(std::string_view bytes) {
  State state;
  Loader loader(bytes);
  walk(loader, state);
  if (!loader.at_end()) throw InputError("checkpoint holds more than a state");
  make_again(state);
  return state;
}

void make_again(State& state) {
  if (state.resting) return;
  check_list(state);
  entail(state.grains, state.boundary.cell, state.contacts);
  std::vector<Index> next;
  index_grains(state.grains.size(), state.contacts, next);
}

}  // namespace grus::dem
