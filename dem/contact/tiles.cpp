// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/tiles.hpp"

#include <algorithm>

#include "dem/contact/pair_kinds.hpp"
#include "dem/kernel/sweep.hpp"
#include "dem/state/shape_kinds.hpp"

namespace grus::dem {

void weigh_tile(const Grains& grains, std::size_t t, std::size_t begin, std::size_t end, Contacts& contacts) {
  std::uint64_t cost = 0;
  for (std::size_t bin = 0; bin < bin_count; ++bin) {
    const PairKind& kind = pair_kind(bin);
    cost += kind.touching * (contacts.apart[bin][t] - contacts.tile[bin][t]) +
            kind.apart * (contacts.tile[bin][t + 1] - contacts.apart[bin][t]);
  }
  for (std::size_t i = begin; i < end; ++i) cost += shape_functions(grains.kind[i]).cost;
  contacts.tile_work[t + 1] = cost;
}

void assign_targets(std::size_t grains, std::span<const std::vector<Index>> crossing, Contacts& contacts,
                    std::vector<Index>& receivers, std::vector<Index>& next) {
  const std::size_t tiles = tile_count(grains), words = tile_words(grains);
  const int bits = tile_bits(grains);
  contacts.remote.assign(grains + 1, 0);
  contacts.before.assign(tiles * words, 0);
  receivers.clear();
  next.resize(grains);
  for (std::size_t t = 0; t < tiles; ++t) {
    const std::size_t first = receivers.size();
    for (const Index k : crossing[t]) receivers.push_back(contacts.b[k]);
    const auto mine = receivers.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(mine, receivers.end());
    receivers.erase(std::unique(mine, receivers.end()), receivers.end());
    for (std::size_t r = first; r < receivers.size(); ++r) {
      const Index b = receivers[r];
      next[b] = static_cast<Index>(grains + r);
      ++contacts.remote[b + 1];
      contacts.before[(b >> bits) * words + t / 64] |= std::uint64_t{1} << (t % 64);
    }
    for (const Index k : crossing[t]) contacts.target[k] = next[contacts.b[k]];
  }
  for (std::size_t i = 0; i < grains; ++i) contacts.remote[i + 1] += contacts.remote[i];
  next.assign(contacts.remote.begin(), contacts.remote.end() - 1);
  contacts.remote_row.assign(receivers.size() + rows_ahead, 0);
  for (std::size_t r = 0; r < receivers.size(); ++r)
    contacts.remote_row[next[receivers[r]]++] = static_cast<Index>(grains + r);
  contacts.load.resize(grains + receivers.size());  // all zero between steps
  for (auto* column : {&contacts.taken, &contacts.done, &contacts.moved}) column->assign(tiles, contacts.round);
}

void index_images(const Cell& cell, Contacts& contacts) {
  contacts.shift.clear(), contacts.images.assign(1, {0, 0, 0});
  if (!cell.periodic()) return;
  contacts.shift.reserve(contacts.size() + overrun);
  for (std::size_t k = 0; k < contacts.begin[first_wall]; ++k) {
    const auto& image = contacts.pair[k].image;
    std::size_t row = 0;
    while (row < contacts.images.size() && contacts.images[row] != image) ++row;
    if (row == contacts.images.size()) contacts.images.push_back(image);
    contacts.shift.push_back(static_cast<Index>(row));
  }
  contacts.shift.resize(contacts.size() + overrun, 0);
}

}  // namespace grus::dem
