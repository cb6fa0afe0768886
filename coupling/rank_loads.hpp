// SPDX-License-Identifier: LGPL-3.0-or-later
// Which rank gets which RVE, by what they cost.
#pragma once

#include <cstdint>
#include <set>
#include <utility>
#include <vector>

namespace grus::coupling {

/// Ranks to which RVEs of these costs (s) go so that the largest sum is small: longest first, each to the least loaded
/// rank; of equal ones to the lowest.
std::vector<int> balance(const std::vector<double>& costs, int ranks);

/// The work that each rank has to do (s), and which has least: each asked and changed in log(ranks).
class Loads {
public:
  explicit Loads(int ranks);
  int idlest() const { return order_.begin()->second; }  // of equal ones the lowest
  int busiest() const { return order_.rbegin()->second; }
  double of(int rank) const { return load_[static_cast<std::size_t>(rank)]; }
  void add(int rank, double cost);
  double mean() const;

private:
  std::vector<double> load_;
  std::set<std::pair<double, int>> order_;
};

/// An RVE where it lives, with its cost (s); and one that is to move.
struct Lodger {
  std::uint64_t slot;
  int rank;
  double cost;
};
struct Move {
  std::uint64_t slot;
  int to;
};

/// Moves after which no rank has more than a tenth above the mean to do, or none helps: the dearest RVE of the busiest
/// rank that leaves the idlest below it, again and again. Each costs the logarithm of their number.
std::vector<Move> moves_to_balance(const std::vector<Lodger>& lodgers, int ranks);

}  // namespace grus::coupling
