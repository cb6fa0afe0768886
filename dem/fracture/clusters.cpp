// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/clusters.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

constexpr double most_damage = 0.35;
constexpr std::size_t nearest = 6;      // ways to the nearest neighbours come first
constexpr std::size_t least_crumb = 4;  // points

/// Nearest neighbours of each point, rows of six: -1 where there is none; `held`: only over intact bonds.
std::vector<int> neighbours(const PeridynamicSolid& solid, bool held) {
  const PointLattice& l = solid.lattice();
  const std::vector<std::uint8_t>& has = held ? solid.intact() : l.bond;
  std::vector<int> at(l.cells, -1), next(nearest * l.size(), -1);
  for (std::size_t i = 0; i < l.size(); ++i) at[l.cell[i]] = static_cast<int>(i);
  for (std::size_t k = 0; k + 1 < l.octet.size(); ++k)
    for (std::uint32_t b = l.octet[k].bond; b < l.octet[k + 1].bond && l.way[b] < nearest; ++b)
      for (std::uint32_t i = l.octet[k].point; i < l.octet[k + 1].point; ++i)
        if (has[b] >> (i - l.octet[k].point) & 1)
          next[nearest * i + l.way[b]] = at[static_cast<std::size_t>(std::int64_t{l.cell[i]} + l.ways[l.way[b]].step)];
  return next;
}

}  // namespace

std::vector<double> damage_of(const PeridynamicSolid& solid) {
  const PointLattice& l = solid.lattice();
  std::vector<double> damage(l.size());
  for (std::size_t k = 0; k + 1 < l.octet.size(); ++k) {
    double all[8] = {}, lost[8] = {};
    for (std::uint32_t b = l.octet[k].bond; b < l.octet[k + 1].bond; ++b) {
      const double weight[2] = {0, l.ways[l.way[b]].weight};
      const unsigned has = l.bond[b], gone = has & ~unsigned{solid.intact()[b]};
      for (unsigned bit = 0; bit < 8; ++bit) all[bit] += weight[has >> bit & 1];
      if (gone == 0) continue;
      for (unsigned bit = 0; bit < 8; ++bit) lost[bit] += weight[gone >> bit & 1];
    }
    for (std::uint32_t i = l.octet[k].point; i < l.octet[k + 1].point; ++i)
      damage[i] = lost[i - l.octet[k].point] / all[i - l.octet[k].point];
  }
  return damage;
}

Clusters clusters_of(const PeridynamicSolid& solid, double least, bool crumbs) {
  const std::size_t n = solid.lattice().size();
  const std::vector<double> damage = damage_of(solid);
  const std::vector<int> next = neighbours(solid, true);
  const auto aside = [&](std::size_t i) { return damage[i] > most_damage || solid.keeps(i); };
  std::vector<int> label(n, -1), stack;
  std::vector<std::pair<long, int>> size;  // less of it, label
  for (std::size_t s = 0; s < n; ++s) {
    if (label[s] >= 0 || aside(s)) continue;
    const int mine = static_cast<int>(size.size());
    long count = 0;
    stack.assign(1, static_cast<int>(s)), label[s] = mine;
    while (!stack.empty()) {
      const auto i = static_cast<std::size_t>(stack.back());
      stack.pop_back(), ++count;
      for (std::size_t w = 0; w < nearest; ++w) {
        const int j = next[nearest * i + w];
        if (j < 0 || label[static_cast<std::size_t>(j)] >= 0 || aside(static_cast<std::size_t>(j))) continue;
        label[static_cast<std::size_t>(j)] = mine, stack.push_back(j);
      }
    }
    size.emplace_back(-count, mine);
  }
  std::sort(size.begin(), size.end());
  std::vector<int> place(size.size(), -1);
  Clusters c;
  for (const auto& [less, mine] : size) {
    const bool large = -static_cast<double>(less) >= least * static_cast<double>(n);
    if (large || (crumbs && static_cast<std::size_t>(-less) >= least_crumb))
      place[static_cast<std::size_t>(mine)] = c.pieces + c.crumbs, ++(large ? c.pieces : c.crumbs);
  }
  for (int& l : label) l = l < 0 ? -1 : place[static_cast<std::size_t>(l)];
  c.piece = std::move(label);
  return c;
}

Clusters torn_apart(const PeridynamicSolid& solid, const PointColumns& u, double least, bool crumbs) {
  const std::size_t n = solid.lattice().size();
  const auto moved = [&](std::size_t i) { return Vec3(u(i, 0), u(i, 1), u(i, 2)); };
  Vec3 middle[2] = {Vec3::Zero(), Vec3::Zero()};  // of the rest, and of those that go with the farthest
  for (std::size_t i = 0; i < n; ++i)
    if (moved(i).squaredNorm() > middle[1].squaredNorm()) middle[1] = moved(i);
  Clusters c{std::vector<int>(n, 0)};
  std::size_t away = 0;
  for (int round = 0; round < 20; ++round) {
    Vec3 sum[2] = {Vec3::Zero(), Vec3::Zero()};
    bool same = round > 0;
    away = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const int at = (moved(i) - middle[1]).squaredNorm() < (moved(i) - middle[0]).squaredNorm();
      same = same && at == c.piece[i];
      c.piece[i] = at, sum[at] += moved(i), away += static_cast<std::size_t>(at);
    }
    if (same || away == 0 || away == n) break;
    middle[0] = sum[0] / static_cast<double>(n - away), middle[1] = sum[1] / static_cast<double>(away);
  }
  if (2 * away > n) {
    for (int& p : c.piece) p = 1 - p;
    away = n - away;
  }
  c.pieces = 1;
  const double enough = least * static_cast<double>(n);
  if (away >= least_crumb && static_cast<double>(away) >= enough)
    c.pieces = 2;
  else if (away >= least_crumb && crumbs)
    c.crumbs = 1;
  else
    std::fill(c.piece.begin(), c.piece.end(), 0);
  return c;
}

void attach(const PeridynamicSolid& solid, Clusters& clusters) {
  if (clusters.pieces == 0) return;
  const PointLattice& l = solid.lattice();
  for (const bool held : {true, false}) {
    const std::vector<int> next = neighbours(solid, held);
    for (bool more = true; more;) {
      more = false;
      const std::vector<int> before = clusters.piece;
      for (std::size_t i = 0; i < l.size(); ++i)
        for (std::size_t w = 0; before[i] < 0 && clusters.piece[i] < 0 && w < nearest; ++w)
          if (const int j = next[nearest * i + w]; j >= 0 && before[static_cast<std::size_t>(j)] >= 0)
            clusters.piece[i] = before[static_cast<std::size_t>(j)], more = true;
    }
  }
  const std::vector<int> reached = clusters.piece;
  for (std::size_t i = 0; i < l.size(); ++i) {  // a point without a nearest neighbour
    if (reached[i] >= 0) continue;
    double least = INFINITY;
    for (std::size_t j = 0; j < l.size(); ++j)
      if (const double d = (l.point[j] - l.point[i]).squaredNorm(); reached[j] >= 0 && d < least)
        least = d, clusters.piece[i] = reached[j];
  }
}

}  // namespace grus::dem
