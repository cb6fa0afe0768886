// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/broad_phase.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/base/error.hpp"

namespace grus::dem {
namespace {

struct Box {  // fractional coordinates: s = inverse * (x - origin)
  Mat3 vectors, inverse;
  Vec3 origin, heights;  // distance between opposite faces
  bool periodic;
};

struct Level {
  double largest = 0;  // radius
  std::array<int, 3> cells{1, 1, 1};
  std::vector<Index> first, member;

  std::size_t index(const std::array<int, 3>& c) const {
    return (static_cast<std::size_t>(c[2]) * cells[1] + c[1]) * cells[0] + c[0];
  }
};

Box box_of(const Grains& grains, const Cell& cell, double skin) {
  Box box{cell.vectors, {}, Vec3::Zero(), {}, cell.periodic()};
  if (!box.periodic) {
    Vec3 low = Vec3::Constant(INFINITY), high = -low;
    for (const auto& g : grains.motion) low = low.cwiseMin(g.position), high = high.cwiseMax(g.position);
    const Vec3 extent = (high - low).array() + std::max(skin, 1e-12);
    box.vectors = Mat3(extent.asDiagonal());
    box.origin = low.array() - 0.25 * std::max(skin, 1e-12);
  }
  box.inverse = box.vectors.inverse();
  for (int k = 0; k < 3; ++k) box.heights[k] = 1 / box.inverse.row(k).norm();
  return box;
}

}  // namespace

Candidates find_candidates(const Grains& grains, const Cell& cell, double skin, Team& team) {
  const std::size_t n = grains.size();
  if (n == 0) return {{}, {0}};
  const Box box = box_of(grains, cell, skin);

  double smallest = INFINITY, largest = 0;
  for (const auto& g : grains.motion) smallest = std::min(smallest, g.radius), largest = std::max(largest, g.radius);
  if (box.periodic && box.heights.minCoeff() < 2 * largest + skin)
    throw InputError(fmt::format("periodic cell of {:.3g} m is smaller than its largest grain ({:.3g} m across): a grain would "
                                 "touch its own image; enlarge the cell",
                                 box.heights.minCoeff(), 2 * largest));

  // Fractional coordinates, folded into the cell; `fold` remembers by how many cell vectors.
  std::vector<Vec3> s(n);
  std::vector<std::array<int, 3>> fold(n, {0, 0, 0});
  std::vector<std::uint8_t> level_of(n);
  std::vector<Level> levels(static_cast<std::size_t>(std::floor(std::log2(largest / smallest) + 1e-9)) + 1);
  std::vector<std::size_t> count(levels.size());
  for (std::size_t i = 0; i < n; ++i) {
    s[i] = box.inverse * (grains.motion[i].position - box.origin);
    for (int k = 0; k < 3; ++k)
      if (box.periodic) fold[i][k] = static_cast<int>(std::floor(s[i][k])), s[i][k] -= fold[i][k];
    const double r = grains.motion[i].radius;
    level_of[i] = static_cast<std::uint8_t>(std::min(levels.size() - 1, static_cast<std::size_t>(std::log2(r / smallest))));
    levels[level_of[i]].largest = std::max(levels[level_of[i]].largest, r);
    ++count[level_of[i]];
  }
  auto cell_of = [&](const Level& level, const Vec3& x) {
    std::array<int, 3> c;
    for (int k = 0; k < 3; ++k) c[k] = std::clamp(static_cast<int>(x[k] * level.cells[k]), 0, level.cells[k] - 1);
    return c;
  };
  for (std::size_t l = 0; l < levels.size(); ++l) {
    if (count[l] == 0) continue;
    const double most = std::cbrt(8.0 * static_cast<double>(count[l])) + 4;  // no more cells than a few for each grain
    for (int k = 0; k < 3; ++k)
      levels[l].cells[k] = std::max(1, static_cast<int>(std::min(box.heights[k] / (2 * levels[l].largest + skin), most)));
    const auto& c = levels[l].cells;
    levels[l].first.assign(static_cast<std::size_t>(c[0]) * c[1] * c[2] + 1, 0);
    levels[l].member.resize(count[l]);
  }
  for (std::size_t i = 0; i < n; ++i) ++levels[level_of[i]].first[levels[level_of[i]].index(cell_of(levels[level_of[i]], s[i])) + 1];
  for (auto& level : levels)
    for (std::size_t c = 1; c < level.first.size(); ++c) level.first[c] += level.first[c - 1];
  for (std::size_t i = n; i-- > 0;) {  // backwards: members end up in ascending order
    auto& level = levels[level_of[i]];
    const std::size_t c = level.index(cell_of(level, s[i]));
    level.member[--level.first[c + 1]] = static_cast<Index>(i);
  }
  // The fill above moved the ends to the starts: first[c + 1] is now where cell c starts.
  for (auto& level : levels)
    if (!level.first.empty()) {
      for (std::size_t c = 0; c + 1 < level.first.size(); ++c) level.first[c] = level.first[c + 1];
      level.first.back() = static_cast<Index>(level.member.size());
    }

  std::vector<std::vector<Candidate>> piece(block_count(n));
  team.blocks(n, [&](std::size_t begin, std::size_t end) {
    std::vector<Candidate>& found = piece[begin / block_size];
    for (std::size_t i = begin; i < end; ++i) {
      const auto& gi = grains.motion[i];
      for (std::size_t l = level_of[i]; l < levels.size(); ++l) {
        const Level& level = levels[l];
        if (level.member.empty()) continue;
        const double reach = gi.radius + level.largest + skin;
        std::array<int, 3> low, high;
        for (int k = 0; k < 3; ++k) {
          low[k] = static_cast<int>(std::floor((s[i][k] - reach / box.heights[k]) * level.cells[k]));
          high[k] = static_cast<int>(std::floor((s[i][k] + reach / box.heights[k]) * level.cells[k]));
          if (!box.periodic) low[k] = std::max(low[k], 0), high[k] = std::min(high[k], level.cells[k] - 1);
        }
        for (int z = low[2]; z <= high[2]; ++z)
          for (int y = low[1]; y <= high[1]; ++y)
            for (int x = low[0]; x <= high[0]; ++x) {
              std::array<int, 3> c{x, y, z}, wrap{0, 0, 0};
              for (int k = 0; k < 3; ++k) {
                wrap[k] = c[k] >= 0 ? c[k] / level.cells[k] : -((level.cells[k] - 1 - c[k]) / level.cells[k]);
                c[k] -= wrap[k] * level.cells[k];
              }
              const std::size_t at = level.index(c);
              const Vec3 shift = box.periodic ? Vec3(box.vectors * Vec3(wrap[0], wrap[1], wrap[2])) : Vec3(Vec3::Zero());
              for (Index m = level.first[at]; m < level.first[at + 1]; ++m) {
                const Index j = level.member[m];
                if (l == level_of[i] && j <= i) continue;  // same level: seen once, from the lower index
                const auto& gj = grains.motion[j];
                const double far = gi.radius + gj.radius + skin;
                const Vec3 d = box.vectors * (s[j] - s[i]) + shift;
                if (d.squaredNorm() >= far * far) continue;
                std::array<std::int16_t, 3> image;
                for (int k = 0; k < 3; ++k) image[k] = static_cast<std::int16_t>(wrap[k] - fold[j][k] + fold[i][k]);
                const auto a = static_cast<Index>(i);
                if (a < j) {
                  found.push_back({a, j, image});
                } else {
                  for (auto& v : image) v = static_cast<std::int16_t>(-v);
                  found.push_back({j, a, image});
                }
              }
            }
      }
    }
  });

  // Rows by a, each sorted by (b, image): the order does not tell who found what.
  Candidates sorted;
  sorted.row.assign(n + 1, 0);
  for (const auto& found : piece)
    for (const auto& c : found) ++sorted.row[c.a + 1];
  for (std::size_t i = 0; i < n; ++i) sorted.row[i + 1] += sorted.row[i];
  sorted.pair.resize(sorted.row[n]);
  std::vector<Index> next(sorted.row.begin(), sorted.row.end() - 1);
  for (const auto& found : piece)
    for (const auto& c : found) sorted.pair[next[c.a]++] = c;
  team.blocks(n, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      std::sort(sorted.pair.begin() + sorted.row[i], sorted.pair.begin() + sorted.row[i + 1],
                [](const Candidate& p, const Candidate& q) { return p.b != q.b ? p.b < q.b : p.image < q.image; });
  });
  return sorted;
}

}  // namespace grus::dem
