// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/rank_loads.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

namespace grus::coupling {

std::vector<int> balance(const std::vector<double>& costs, int ranks) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return costs[a] > costs[b]; });
  Loads loads(ranks);
  std::vector<int> to(costs.size());
  for (const auto i : order) {
    to[i] = loads.idlest();
    loads.add(to[i], costs[i]);
  }
  return to;
}

Loads::Loads(int ranks) : load_(static_cast<std::size_t>(ranks), 0) {
  for (int r = 0; r < ranks; ++r) order_.emplace(0, r);
}

void Loads::add(int rank, double cost) {
  double& load = load_[static_cast<std::size_t>(rank)];
  order_.erase({load, rank});
  load += cost;
  order_.emplace(load, rank);
}

double Loads::mean() const {
  return std::accumulate(load_.begin(), load_.end(), 0.0) / static_cast<double>(load_.size());
}

std::vector<Move> moves_to_balance(const std::vector<Lodger>& lodgers, int ranks) {
  Loads loads(ranks);
  for (const Lodger& l : lodgers) loads.add(l.rank, l.cost);
  const double enough = 1.1 * loads.mean();
  std::vector<Move> moves;
  if (loads.of(loads.busiest()) <= enough) return moves;
  std::vector<std::set<std::pair<double, std::uint64_t>>> of(static_cast<std::size_t>(ranks));  // by cost
  for (const Lodger& l : lodgers) of[static_cast<std::size_t>(l.rank)].emplace(l.cost, l.slot);
  while (moves.size() < lodgers.size()) {
    const int from = loads.busiest(), to = loads.idlest();
    if (loads.of(from) <= enough) break;
    auto &theirs = of[static_cast<std::size_t>(from)], &new_home = of[static_cast<std::size_t>(to)];
    const auto dearer = theirs.lower_bound({loads.of(from) - loads.of(to), 0});
    if (dearer == theirs.begin()) break;  // each would only turn the two round
    const auto [cost, slot] = *std::prev(dearer);
    theirs.erase(std::prev(dearer)), new_home.emplace(cost, slot);
    loads.add(from, -cost), loads.add(to, cost);
    moves.push_back({slot, to});
  }
  return moves;
}

}  // namespace grus::coupling
