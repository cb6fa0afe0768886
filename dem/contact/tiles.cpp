// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/tiles.hpp"

#include <algorithm>

#include "dem/base/renew.hpp"
#include "dem/contact/mesh_pairs.hpp"
#include "dem/contact/pair_kinds.hpp"
#include "dem/kernel/look_ahead.hpp"
#include "dem/kernel/sweep.hpp"
#include "dem/state/shape_kinds.hpp"

namespace grus::dem {

void make_room(std::size_t pairs, Plan& plan) {
  const auto make = [&](std::vector<Index>& column, std::size_t beyond) {
    renew(column, pairs + beyond);
    std::fill_n(column.begin() + static_cast<std::ptrdiff_t>(pairs), beyond, Index{0});
  };
  for (auto* column : {&plan.a, &plan.law, &plan.target}) make(*column, overrun);
  make(plan.b, overrun + grains_ahead);
}

void weigh_tile(const Grains& grains, std::size_t t, Contacts& contacts) {
  std::uint64_t cost = 0;
  for (std::size_t bin = 0; bin < bin_count; ++bin) {
    const PairKind& kind = pair_kind(bin);
    cost += kind.touching * (contacts.apart[bin][t] - contacts.tile[bin][t]) +
            kind.apart * (contacts.tile[bin][t + 1] - contacts.apart[bin][t]);
  }
  const std::size_t size = tile_size(grains.size()), end = std::min(grains.size(), (t + 1) * size);
  for (std::size_t i = t * size; i < end; ++i) cost += shape_functions(grains.kind[i]).cost;
  contacts.plan.tile_work[t + 1] = cost;
}

namespace {

void assign_targets(std::size_t grains, std::span<const std::vector<Index>> crossing, Plan& plan,
                    std::vector<Index>& receivers, std::vector<Index>& next) {
  const std::size_t tiles = tile_count(grains), words = tile_words(grains);
  const int bits = tile_bits(grains);
  plan.remote.assign(grains + 1, 0);
  plan.before.assign(tiles * words, 0);
  receivers.clear();
  next.resize(grains);
  for (std::size_t t = 0; t < tiles; ++t) {
    const std::size_t first = receivers.size();
    for (const Index k : crossing[t]) receivers.push_back(plan.b[k]);
    const auto mine = receivers.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(mine, receivers.end());
    receivers.erase(std::unique(mine, receivers.end()), receivers.end());
    for (std::size_t r = first; r < receivers.size(); ++r) {
      const Index b = receivers[r];
      next[b] = static_cast<Index>(grains + r);
      ++plan.remote[b + 1];
      plan.before[(b >> bits) * words + t / 64] |= std::uint64_t{1} << (t % 64);
    }
    for (const Index k : crossing[t]) plan.target[k] = next[plan.b[k]];
  }
  for (std::size_t i = 0; i < grains; ++i) plan.remote[i + 1] += plan.remote[i];
  next.assign(plan.remote.begin(), plan.remote.end() - 1);
  plan.remote_row.assign(receivers.size() + rows_ahead, 0);
  for (std::size_t r = 0; r < receivers.size(); ++r)
    plan.remote_row[next[receivers[r]]++] = static_cast<Index>(grains + r);
  plan.load.resize(grains + receivers.size());  // all zero between steps
  for (auto* column : {&plan.taken, &plan.done, &plan.moved}) column->assign(tiles, plan.round);
}

}  // namespace

void finish_plan(const Grains& grains, const Cell& cell, std::span<const std::vector<Index>> crossing,
                 Contacts& contacts, std::vector<Index>& receivers, std::vector<Index>& next) {
  Plan& plan = contacts.plan;
  const std::size_t tiles = tile_count(grains.size());
  plan.tile_work[0] = 0;
  for (std::size_t t = 0; t < tiles; ++t) plan.tile_work[t + 1] += plan.tile_work[t];
  plan.energy.resize(std::max(plan.energy.size(), tiles));
  assign_targets(grains.size(), crossing, plan, receivers, next);
  index_images(cell, contacts);
  for (std::size_t k = contacts.begin[sphere_mesh]; k < contacts.size(); ++k)  // each has a plane of its own
    plan.target[k] = static_cast<Index>(k - contacts.begin[sphere_mesh]);
  make_mesh_room(contacts);
}

void entail(const Grains& grains, const Cell& cell, Contacts& contacts) {
  const std::size_t tiles = tile_count(grains.size());
  const int bits = tile_bits(grains.size());
  std::vector<std::vector<Index>> crossing(tiles);
  contacts.plan = {};
  make_room(contacts.size(), contacts.plan);
  contacts.plan.tile_work.resize(tiles + 1);
  contacts.guesses.row.assign(contacts.begin[hull_hull + 1] - contacts.begin[hull_hull], {});
  for (std::size_t t = 0; t < tiles; ++t) {
    for (std::size_t bin = 0; bin < bin_count; ++bin)
      for (std::size_t k = contacts.tile[bin][t]; k < contacts.tile[bin][t + 1]; ++k)
        plan_pair(contacts.pair[k], k, t, bin >= first_wall, bits, contacts.plan, crossing[t]);
    weigh_tile(grains, t, contacts);
  }
  std::vector<Index> receivers, next;
  finish_plan(grains, cell, crossing, contacts, receivers, next);
}

void index_images(const Cell& cell, Contacts& contacts) {
  Plan& plan = contacts.plan;
  plan.shift.clear(), plan.images.assign(1, {0, 0, 0});
  if (!cell.periodic()) return;
  plan.shift.reserve(contacts.size() + overrun);
  for (std::size_t k = 0; k < contacts.begin[first_wall]; ++k) {
    const auto& image = contacts.pair[k].image;
    std::size_t row = 0;
    while (row < plan.images.size() && plan.images[row] != image) ++row;
    if (row == plan.images.size()) plan.images.push_back(image);
    plan.shift.push_back(static_cast<Index>(row));
  }
  plan.shift.resize(contacts.size() + overrun, 0);
}

}  // namespace grus::dem
