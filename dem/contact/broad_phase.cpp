// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/broad_phase.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/base/renew.hpp"

namespace grus::dem {
namespace {

constexpr std::size_t most_levels = 64;

using Level = SearchRoom::Level;
using Member = SearchRoom::Member;

struct Box {  // fractional coordinates: s = inverse * (x - origin)
  Mat3 vectors, inverse;
  Vec3 origin, heights;  // distance between opposite faces
  bool periodic;
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

std::size_t cell_index(const Level& level, int x, int y, int z) {
  return (static_cast<std::size_t>(z) * static_cast<std::size_t>(level.cells[1]) + static_cast<std::size_t>(y)) *
             static_cast<std::size_t>(level.cells[0]) +
         static_cast<std::size_t>(x);
}

std::size_t cell_of(const Level& level, const Vec3& s) {
  std::array<int, 3> c;
  for (std::size_t k = 0; k < 3; ++k)
    c[k] = std::clamp(static_cast<int>(s[static_cast<int>(k)] * level.cells[k]), 0, level.cells[k] - 1);
  return cell_index(level, c[0], c[1], c[2]);
}

/// A level for each doubling of the radius, with cells in which a grain of it touches neighbouring cells at most.
void choose_levels(const Grains& grains, const Box& box, double skin, SearchRoom& out) {
  const std::size_t n = grains.size();
  double smallest = INFINITY, largest = 0;
  for (const auto& g : grains.motion) smallest = std::min(smallest, g.radius), largest = std::max(largest, g.radius);
  if (box.periodic && box.heights.minCoeff() < 2 * largest + skin)
    throw Unstable(fmt::format(
        "periodic cell of {:.3g} m has become smaller than its largest grain ({:.3g} m across) and the {:.2g} m ahead "
        "within which it looks for others: a grain would touch its own image; use a larger cell, or load less",
        box.heights.minCoeff(), 2 * largest, skin));
  // More than 64 doublings in size: all that is larger shares the last level.
  const auto depth = std::min<std::size_t>(
      most_levels, static_cast<std::size_t>(std::floor(std::log2(largest / smallest) + 1e-9)) + 1);
  out.levels.resize(depth);
  std::array<double, most_levels> bound;  // radius at which the next level begins
  for (std::size_t l = 0; l < depth; ++l)
    bound[l] = l + 1 < depth ? std::ldexp(smallest, static_cast<int>(l) + 1) : INFINITY;
  std::vector<std::size_t> count(depth, 0);
  for (auto& level : out.levels) level.largest = 0;
  out.level_of.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double r = grains.motion[i].radius;
    std::size_t l = 0;
    while (r >= bound[l]) ++l;
    out.level_of[i] = static_cast<std::uint8_t>(l);
    out.levels[l].largest = std::max(out.levels[l].largest, r);
    ++count[l];
  }
  for (std::size_t l = 0; l < depth; ++l) {
    Level& level = out.levels[l];
    const double most = std::cbrt(8.0 * static_cast<double>(count[l])) + 4;  // no more cells than a few for each grain
    for (int k = 0; k < 3; ++k)
      level.cells[static_cast<std::size_t>(k)] =
          std::max(1, static_cast<int>(std::min(box.heights[k] / (2 * level.largest + skin), most)));
    level.first.assign(static_cast<std::size_t>(level.cells[0]) * static_cast<std::size_t>(level.cells[1]) *
                               static_cast<std::size_t>(level.cells[2]) +
                           1,
                       0);
    level.member.resize(count[l]);
  }
}

/// Puts the grains into the cells of their levels.
void fill_levels(const Grains& grains, const Box& box, double skin, SearchRoom& out) {
  choose_levels(grains, box, skin, out);
  const std::size_t n = grains.size();
  out.folded.resize(n), out.place.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    Vec3 s = box.inverse * (grains.motion[i].position - box.origin);
    Member& m = out.folded[i];
    m.fold = {0, 0, 0};
    if (box.periodic)
      for (int k = 0; k < 3; ++k) {
        const double whole = std::floor(s[k]);
        m.fold[static_cast<std::size_t>(k)] = static_cast<std::int16_t>(whole), s[k] -= whole;
      }
    m.position = box.vectors * s;
    m.radius = grains.motion[i].radius;
    m.grain = static_cast<Index>(i);
    Level& level = out.levels[out.level_of[i]];
    out.place[i] = static_cast<Index>(cell_of(level, s));
    ++level.first[out.place[i] + 1];
  }
  for (auto& level : out.levels)
    for (std::size_t c = 1; c < level.first.size(); ++c) level.first[c] += level.first[c - 1];
  for (std::size_t i = n; i-- > 0;) {  // backwards: members end up in ascending order
    Level& level = out.levels[out.level_of[i]];
    level.member[--level.first[out.place[i] + 1]] = out.folded[i];
  }
  // The fill above moved the ends to the starts: first[c + 1] is now where cell c starts.
  for (auto& level : out.levels) {
    for (std::size_t c = 0; c + 1 < level.first.size(); ++c) level.first[c] = level.first[c + 1];
    level.first.back() = static_cast<Index>(level.member.size());
  }
}

/// Calls f(cell, image) for whole numbers low..high, the cells taken round the box.
template <class F>
void each_wrapped(int low, int high, int cells, bool periodic, F&& f) {
  if (!periodic) {
    for (int c = std::max(low, 0); c <= std::min(high, cells - 1); ++c) f(c, 0);
    return;
  }
  int image = 0, c = low;
  while (c < 0) c += cells, --image;
  for (int k = low; k <= high; ++k, ++c) {
    while (c >= cells) c -= cells, ++image;
    f(c, image);
  }
}

/// Grains of a level near one grain, but for those that `elsewhere` says are found from the other side.
template <class F>
void search(const Box& box, const Level& level, const Member& mine, double skin, std::vector<Candidate>& found,
            F&& elsewhere) {
  const double reach = mine.radius + level.largest + skin;
  const Vec3 s = box.inverse * mine.position;
  std::array<int, 3> low, high;
  for (int k = 0; k < 3; ++k) {
    const double span = reach / box.heights[k];
    auto cell = [&](double at) {
      return static_cast<int>(std::clamp(std::floor(at * level.cells[static_cast<std::size_t>(k)]), -1e9, 1e9));
    };
    low[static_cast<std::size_t>(k)] = cell(s[k] - span), high[static_cast<std::size_t>(k)] = cell(s[k] + span);
  }
  auto look = [&](std::size_t begin, std::size_t end, const std::array<int, 3>& wrap) {
    const Vec3 from =
        box.periodic ? Vec3(mine.position - box.vectors * Vec3(wrap[0], wrap[1], wrap[2])) : mine.position;
    for (std::size_t m = begin; m < end; ++m) {
      const Member& other = level.member[m];
      const double far = mine.radius + other.radius + skin;
      if ((other.position - from).squaredNorm() >= far * far) continue;
      if (elsewhere(other.grain)) continue;
      std::array<std::int16_t, 3> image;
      for (std::size_t k = 0; k < 3; ++k) image[k] = static_cast<std::int16_t>(wrap[k] - other.fold[k] + mine.fold[k]);
      if (mine.grain < other.grain) {
        found.push_back({mine.grain, other.grain, image});
      } else {
        for (auto& v : image) v = static_cast<std::int16_t>(-v);
        found.push_back({other.grain, mine.grain, image});
      }
    }
  };
  each_wrapped(low[2], high[2], level.cells[2], box.periodic, [&](int z, int wz) {
    each_wrapped(low[1], high[1], level.cells[1], box.periodic, [&](int y, int wy) {
      const std::size_t line = cell_index(level, 0, y, z);  // cells along x lie one after the other
      int c = low[0], wx = 0;
      if (!box.periodic)
        return look(level.first[line + static_cast<std::size_t>(std::max(c, 0))],
                    level.first[line + static_cast<std::size_t>(std::min(high[0], level.cells[0] - 1)) + 1],
                    {0, wy, wz});
      while (c < 0) c += level.cells[0], --wx;
      for (int left = high[0] - low[0] + 1; left > 0; ++wx) {
        while (c >= level.cells[0]) c -= level.cells[0], ++wx;
        const int run = std::min(left, level.cells[0] - c);
        look(level.first[line + static_cast<std::size_t>(c)], level.first[line + static_cast<std::size_t>(c + run)],
             {wx, wy, wz});
        left -= run, c = 0;
      }
    });
  });
}

/// Rows by a, each sorted by (b, image), of what the first pieces hold: the order does not tell who found what.
void make_rows(std::size_t n, std::size_t pieces, SearchRoom& room, Candidates& out, Team& team) {
  const bool large = n > large_sample;
  if (large) room.levels = {}, room.folded = {}, room.level_of = {}, room.place = {};
  const std::span found(room.piece.data(), pieces);
  out.row.assign(n + 1, 0);
  for (const auto& piece : found)
    for (const auto& c : piece) ++out.row[c.a + 1];
  for (std::size_t i = 0; i < n; ++i) out.row[i + 1] += out.row[i];
  renew(out.pair, out.row[n]);
  room.next.assign(out.row.begin(), out.row.end() - 1);
  for (const auto& piece : found)
    for (const auto& c : piece) out.pair[room.next[c.a]++] = c;
  if (large) room.piece = {}, room.next = {};
  team.blocks(n, [&](std::size_t begin, std::size_t end) {
    auto before = [](const Candidate& p, const Candidate& q) { return p.b != q.b ? p.b < q.b : p.image < q.image; };
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = out.row[i] + 1; k < out.row[i + 1]; ++k) {  // by insertion: rows are short
        const Candidate c = out.pair[k];
        std::size_t to = k;
        for (; to > out.row[i] && before(c, out.pair[to - 1]); --to) out.pair[to] = out.pair[to - 1];
        out.pair[to] = c;
      }
  });
}

}  // namespace

void refuse_small_cell(const Grains& grains, const Cell& cell, double skin) {
  if (!cell.periodic()) return;
  double largest = 0;
  for (const auto& g : grains.motion) largest = std::max(largest, g.radius);
  if (cell.height() < 2 * largest + skin)
    throw InputError(
        fmt::format("periodic cell of {:.3g} m is smaller than its largest grain ({:.3g} m across) and the neighbour "
                    "skin: a grain would "
                    "touch its own image; enlarge the cell",
                    cell.height(), 2 * largest));
}

void find_candidates(const Grains& grains, const Cell& cell, double skin, Candidates& out, SearchRoom& room,
                     Team& team) {
  const std::size_t n = grains.size(), pieces = block_count(n);
  room.piece.resize(std::max(room.piece.size(), pieces));
  for (auto& found : room.piece) found.clear();
  if (n > large_sample) {
    out.pair = {};
    if (out.row.size() == n + 1)  // as many as the last time
      for (std::size_t p = 0; p < pieces; ++p)
        room.piece[p].reserve(with_reserve(out.row[std::min(n, (p + 1) * block_size)] - out.row[p * block_size]));
  }
  if (n > 0) {
    const Box box = box_of(grains, cell, skin);
    fill_levels(grains, box, skin, room);
    team.blocks(n, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t l = room.level_of[i]; l < room.levels.size(); ++l) {
          const Index least = l == room.level_of[i] ? static_cast<Index>(i + 1) : 0;  // pairs of one level once
          if (!room.levels[l].member.empty())
            search(box, room.levels[l], room.folded[i], skin, room.piece[i / block_size],
                   [=](Index other) { return other < least; });
        }
    });
  }
  make_rows(n, pieces, room, out, team);
}

void find_candidates_of(std::span<const Index> few, const std::vector<std::uint8_t>& marked, const Grains& grains,
                        const Cell& cell, double skin, Candidates& out, SearchRoom& room, Team& team) {
  const std::size_t n = grains.size();
  if (room.piece.empty()) room.piece.resize(1);
  auto& found = room.piece[0];
  found.clear();
  if (!few.empty()) {
    const Box box = box_of(grains, cell, skin);
    fill_levels(grains, box, skin, room);
    for (const Index i : few)
      for (const Level& level : room.levels)
        if (!level.member.empty())
          search(box, level, room.folded[i], skin, found,
                 [&](Index other) { return other == i || (other < i && marked[other]); });
  }
  make_rows(n, 1, room, out, team);
}

}  // namespace grus::dem
