// SPDX-License-Identifier: LGPL-3.0-or-later
// The host of many ranks: RVEs on all of them, as seen from rank 0, which owns the macro problem and gives out the
// work. Decisions are taken in one place and RVEs do not see each other: results do not depend on the number of ranks.
#pragma once

#include <mpi.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>

#include "coupling/rank_loads.hpp"
#include "dem/rves/rve_host.hpp"

namespace grus::coupling {

/// Rank 0 only; the other ranks run `serve` meanwhile. The destructor sends them home.
class RveFarm {
public:
  RveFarm(MPI_Comm comm, std::shared_ptr<const dem::Model> model, const dem::ResponseOptions& options, int threads);
  ~RveFarm();
  RveFarm(const RveFarm&) = delete;
  RveFarm& operator=(const RveFarm&) = delete;

  /// A new slot on the rank with the least to do; `cost` (s) is what it is expected to take.
  void put(std::uint64_t slot, const dem::State& state, double cost);
  void put(std::uint64_t slot, const std::string& state, double cost);  // bytes of a dem::HostedRve
  /// A copy of a committed state as a new slot.
  void copy(std::uint64_t from, std::uint64_t to);
  void drop(std::uint64_t slot);
  /// The watch is asked while RVEs of this rank advance.
  std::vector<dem::Outcome> advance(const std::vector<dem::Task>& tasks, const dem::Watch& watch = {},
                                    std::vector<dem::Outcome> room = {});
  /// Commits the slots' last advance and tells what they have become.
  std::vector<dem::Facts> commit(const std::vector<std::uint64_t>& slots);
  std::vector<dem::Facts> facts(const std::vector<std::uint64_t>& slots);
  std::string fetch(std::uint64_t slot);  // bytes of a dem::HostedRve: the committed state and what it has to catch up
  dem::State whole(dem::State state) const { return host_.whole(std::move(state)); }

  /// Moves slots where what they cost since the last call is out of balance by more than a tenth.
  void rebalance();
  std::uint64_t moved() const { return moved_; }
  double cost(std::uint64_t slot) const { return homes_.at(slot).cost; }
  double spent(std::uint64_t slot) const { return homes_.at(slot).spent; }  // s of its answers since the last such look
  int ranks() const { return ranks_; }
  /// From now on every advance notes what each RVE cost: its wall time on its rank, of that the tangent's, its DEM
  /// steps, and the time that this rank spent to tell its rank and to read the answer (0: it lives here).
  void record_costs() { costs_.emplace("sweep,slot,rank,seconds,tangent_seconds,steps,message_seconds\n"); }
  const std::optional<std::string>& costs() const { return costs_; }
  /// What rows of costs call a slot, and the rank of a farm that is one of many.
  void call_in_costs(std::uint64_t slot, std::int64_t name, int rank) {
    if (costs_) called_[slot] = name, rank_ = rank;
  }
  /// Bytes that went to other ranks, and that came back, since the start.
  std::array<std::uint64_t, 2> traffic() const { return {sent_, received_}; }

private:
  struct Home {
    int rank;
    double cost;       // s: expected, or measured between the last two calls of rebalance
    double spent = 0;  // s, since then
  };
  std::int64_t called(std::uint64_t slot) const;
  void settle(std::uint64_t slot, int rank, double cost);
  void ask(int rank, const std::string& request);
  void drain(int rank);
  std::string answer(int rank);  // throws what the rank has thrown
  void place(int rank, std::uint64_t slot, const std::string& state, double cost);
  std::vector<dem::Outcome> advance_on_ranks(const std::vector<dem::Task>& tasks, const dem::Watch& watch,
                                             std::vector<double>& telling);
  std::vector<dem::Facts> told(bool commit, const std::vector<std::uint64_t>& slots);

  MPI_Comm comm_;
  int ranks_;
  dem::RveHost host_;
  std::vector<int> owed_;                          // answers of each rank that are on their way
  std::unordered_map<std::uint64_t, Home> homes_;  // looked up for each point in each sweep
  Loads loads_;
  std::uint64_t moved_ = 0, sweeps_ = 0, sent_ = 0, received_ = 0;
  std::optional<std::string> costs_;
  std::map<std::uint64_t, std::int64_t> called_;  // slots in costs; empty: as they are numbered
  int rank_ = 0;                                  // of this process, in costs
};
static_assert(dem::Host<RveFarm>);

/// Ranks above 0 do this until the farm is gone.
void serve(MPI_Comm comm, const std::shared_ptr<const dem::Model>& model, const dem::ResponseOptions& options,
           int threads);

}  // namespace grus::coupling
