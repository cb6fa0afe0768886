// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/state/order.hpp"

#include <algorithm>

namespace grus::dem {

std::vector<Index> order_in_space(const Grains& g) {
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (const auto& m : g.motion) low = low.cwiseMin(m.position), high = high.cwiseMax(m.position);
  constexpr int levels = 20;
  const double scale = (1 << levels) / std::max((high - low).maxCoeff(), 1e-300) * (1 - 1e-9);
  std::vector<std::pair<std::uint64_t, Index>> key(g.size());
  for (std::size_t i = 0; i < g.size(); ++i) {
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const auto x = static_cast<std::uint64_t>((g.motion[i].position[k] - low[k]) * scale);
      for (int b = 0; b < levels; ++b) code |= (x >> b & 1) << (3 * b + k);
    }
    key[i] = {code, static_cast<Index>(i)};
  }
  std::sort(key.begin(), key.end());
  std::vector<Index> order;
  for (const auto& [code, i] : key) order.push_back(i);
  return order;
}

void reorder(Grains& g, std::span<const Index> order) {
  for_each_column(g, [&](auto& column) {
    if (column.empty()) return;
    auto sorted = column;
    for (std::size_t i = 0; i < order.size(); ++i) sorted[i] = column[order[i]];
    column = std::move(sorted);
  });
}

void free_hulls(Grains& g, std::vector<Wall>& walls, HullGuesses& guesses) {
  if (g.hull.empty()) return;
  const std::size_t rows = g.hulls->row.size();
  std::vector<std::uint8_t> wanted(rows, 0);
  for (const Index row : g.hull) wanted[row] = 1;
  for (const Wall& wall : walls)
    if (const auto* roller = std::get_if<RollerWall>(&wall.shape)) wanted[roller->hull] = 1;
  const auto live = static_cast<std::size_t>(std::count(wanted.begin(), wanted.end(), 1));
  if (4 * (rows - live) <= rows) return;
  std::vector<Index> place;
  g.hulls = std::make_shared<HullStore>(only(*g.hulls, wanted, place));
  for (Index& row : g.hull) row = place[row];
  for (Wall& wall : walls)
    if (auto* roller = std::get_if<RollerWall>(&wall.shape)) roller->hull = place[roller->hull];
  std::fill(guesses.row.begin(), guesses.row.end(), HullGuesses::Row{});  // they go by the rows
}

void sort_in_space(Grains& g) { reorder(g, order_in_space(g)); }

}  // namespace grus::dem
