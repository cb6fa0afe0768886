// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/hilbert_cut.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace grus::fem {

std::uint64_t hilbert_place(std::array<std::uint32_t, 3> at, int dimensions, int bits) {
  const auto n = static_cast<std::size_t>(dimensions);
  const std::uint32_t top = 1u << (bits - 1);
  for (std::uint32_t bit = top; bit > 1; bit >>= 1)  // turns and mirrors of the smaller cubes, undone
    for (std::size_t k = 0; k < n; ++k) {
      const std::uint32_t below = bit - 1;
      if ((at[k] & bit) != 0) {
        at[0] ^= below;
      } else {
        const std::uint32_t swapped = (at[0] ^ at[k]) & below;
        at[0] ^= swapped, at[k] ^= swapped;
      }
    }
  for (std::size_t k = 1; k < n; ++k) at[k] ^= at[k - 1];  // Gray code
  std::uint32_t flips = 0;
  for (std::uint32_t bit = top; bit > 1; bit >>= 1)
    if ((at[n - 1] & bit) != 0) flips ^= bit - 1;
  std::uint64_t place = 0;
  for (int bit = bits - 1; bit >= 0; --bit)
    for (std::size_t k = 0; k < n; ++k) place = place << 1 | ((at[k] ^ flips) >> bit & 1);
  return place;
}

std::vector<std::int32_t> hilbert_cut(const std::vector<Point>& middles, const std::vector<double>& costs, int parts) {
  constexpr int bits = 20;
  Point low, high;
  low.fill(INFINITY), high.fill(-INFINITY);
  for (const Point& x : middles)
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], x[k]), high[k] = std::max(high[k], x[k]);
  const int dimensions = high[2] > low[2] ? 3 : 2;
  double longest = 0;
  for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, high[k] - low[k]);
  std::vector<std::uint64_t> place;
  for (const Point& x : middles) {
    std::array<std::uint32_t, 3> at{};
    for (std::size_t k = 0; k < 3 && longest > 0; ++k)
      at[k] = static_cast<std::uint32_t>((x[k] - low[k]) / longest * ((1u << bits) - 1));
    place.push_back(hilbert_place(at, dimensions, bits));
  }
  std::vector<std::size_t> order(middles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return place[a] != place[b] ? place[a] < place[b] : a < b; });
  const double all = std::accumulate(costs.begin(), costs.end(), 0.0);
  std::vector<std::int32_t> part(middles.size());
  double before = 0;
  for (const std::size_t k : order) {
    part[k] = std::min(parts - 1, static_cast<std::int32_t>((before + 0.5 * costs[k]) / all * parts));
    before += costs[k];
  }
  return part;
}

}  // namespace grus::fem
