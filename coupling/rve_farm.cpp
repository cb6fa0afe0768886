// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/rve_farm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "dem/io/archive.hpp"

namespace grus::coupling {
namespace {

using dem::Loader;
using dem::Saver;

enum class Command : std::uint8_t { put, copy, drop, advance, commit, facts, fetch, stop };
constexpr int request_tag = 1, answer_tag = 2;

void send(MPI_Comm comm, int rank, int tag, const std::string& bytes) {
  // Pieces: a count is an int, and states of many grains may be large.
  const std::uint64_t size = bytes.size();
  MPI_Send(&size, 1, MPI_UINT64_T, rank, tag, comm);
  for (std::uint64_t at = 0; at < size; at += 1u << 30) MPI_Send(bytes.data() + at, static_cast<int>(std::min<std::uint64_t>(size - at, 1u << 30)), MPI_CHAR, rank, tag, comm);
}

std::string receive(MPI_Comm comm, int rank, int tag) {
  std::uint64_t size = 0;
  MPI_Recv(&size, 1, MPI_UINT64_T, rank, tag, comm, MPI_STATUS_IGNORE);
  std::string bytes(size, '\0');
  for (std::uint64_t at = 0; at < size; at += 1u << 30)
    MPI_Recv(bytes.data() + at, static_cast<int>(std::min<std::uint64_t>(size - at, 1u << 30)), MPI_CHAR, rank, tag, comm, MPI_STATUS_IGNORE);
  return bytes;
}

template <class A, class T>
void archive_task(A& a, T& t) {
  a.plain(t.slot), a.column(t.path), a.plain(t.duration), a.plain(t.real_time), a.plain(t.tangent);
}

template <class A, class O>
void archive_outcome(A& a, O& o) {
  auto& r = o.response;
  a.plain(r.stress), a.plain(r.tangent), a.plain(r.stable), a.plain(r.unbalanced_force), a.plain(r.stress_change);
  a.plain(r.steps), a.plain(r.hold_steps), a.plain(r.breakages), a.plain(r.pieces), a.text(r.failure), a.plain(o.seconds), a.plain(o.elastic), a.plain(o.elastic_error);
}

std::string request(Command c, const std::vector<std::uint64_t>& slots) {
  Saver s;
  s.plain(c), s.column(slots);
  return s.take();
}

/// One request, answered on the rank that it came to; false: stop.
bool handle(RveHost& host, const std::string& bytes, std::string& answer) {
  Loader in(bytes);
  Saver out;
  Command c;
  std::vector<std::uint64_t> slots;
  in.plain(c), in.column(slots);
  switch (c) {
    case Command::stop: return false;
    case Command::put: {
      std::string state;
      in.text(state);
      host.put(slots[0], HostedRve::from(state));
      break;
    }
    case Command::copy: host.copy(slots[0], slots[1]); break;
    case Command::drop: host.drop(slots[0]); break;
    case Command::advance: {
      std::vector<Task> tasks(slots.size());
      for (Task& t : tasks) archive_task(in, t);
      for (const Outcome& o : host.advance(tasks)) archive_outcome(out, o);
      break;
    }
    case Command::commit:
      for (const auto slot : slots) host.commit(slot);
      [[fallthrough]];
    case Command::facts:
      for (const auto slot : slots) out.plain(host.facts(slot));
      break;
    case Command::fetch: out.text(host.hosted(slots[0]).bytes()); break;
  }
  answer = out.take();
  return true;
}

}  // namespace

std::vector<int> balance(const std::vector<double>& costs, int ranks) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return costs[a] > costs[b]; });
  std::vector<double> load(static_cast<std::size_t>(ranks), 0);
  std::vector<int> to(costs.size());
  for (const auto i : order) {
    const auto least = std::min_element(load.begin(), load.end());
    to[i] = static_cast<int>(least - load.begin());
    *least += costs[i];
  }
  return to;
}

RveFarm::RveFarm(MPI_Comm comm, std::shared_ptr<const dem::Model> model, const ResponseOptions& options, int threads)
    : comm_(comm), host_(std::move(model), options, threads) {
  MPI_Comm_size(comm, &ranks_);
}

RveFarm::~RveFarm() {
  for (int r = 1; r < ranks_; ++r) send(comm_, r, request_tag, request(Command::stop, {}));
}

void RveFarm::ask(int rank, const std::string& bytes) { send(comm_, rank, request_tag, bytes); }
std::string RveFarm::answer(int rank) { return receive(comm_, rank, answer_tag); }

int RveFarm::idlest() const {
  std::vector<double> load(static_cast<std::size_t>(ranks_), 0);
  for (const auto& [slot, home] : homes_) load[static_cast<std::size_t>(home.rank)] += home.cost;
  return static_cast<int>(std::min_element(load.begin(), load.end()) - load.begin());
}

void RveFarm::put(std::uint64_t slot, const dem::State& state, double cost) {
  if (const int rank = idlest(); rank == 0) {
    host_.put(slot, {state, dem::Mat3::Identity(), false});
    homes_[slot] = {0, cost};
  } else {
    put_bytes(slot, HostedRve{state, dem::Mat3::Identity(), false}.bytes(), cost);
  }
}

void RveFarm::put_bytes(std::uint64_t slot, const std::string& state, double cost) { place(idlest(), slot, state, cost); }

void RveFarm::place(int rank, std::uint64_t slot, const std::string& state, double cost) {
  homes_[slot] = {rank, cost};
  if (rank == 0) return host_.put(slot, HostedRve::from(state));
  Saver s;
  s.plain(Command::put), s.column(std::vector<std::uint64_t>{slot}), s.text(state);
  ask(rank, s.take());
  answer(rank);
}

void RveFarm::copy(std::uint64_t from, std::uint64_t to) {
  const Home home = homes_.at(from);
  const int rank = idlest();
  if (rank != home.rank) return put_bytes(to, fetch(from), home.cost);
  homes_[to] = home;
  if (rank == 0) return host_.copy(from, to);
  ask(rank, request(Command::copy, {from, to}));
  answer(rank);
}

void RveFarm::drop(std::uint64_t slot) {
  const int rank = homes_.at(slot).rank;
  homes_.erase(slot);
  if (rank == 0) return host_.drop(slot);
  ask(rank, request(Command::drop, {slot}));
  answer(rank);
}

std::vector<Outcome> RveFarm::advance(const std::vector<Task>& tasks) {
  std::vector<std::vector<std::size_t>> of(static_cast<std::size_t>(ranks_));
  for (std::size_t i = 0; i < tasks.size(); ++i) of[static_cast<std::size_t>(homes_.at(tasks[i].slot).rank)].push_back(i);
  for (int r = 1; r < ranks_; ++r) {
    const auto& mine = of[static_cast<std::size_t>(r)];
    if (mine.empty()) continue;
    Saver s;
    std::vector<std::uint64_t> slots;
    for (const auto i : mine) slots.push_back(tasks[i].slot);
    s.plain(Command::advance), s.column(slots);
    for (const auto i : mine) archive_task(s, tasks[i]);
    ask(r, s.take());
  }
  std::vector<Outcome> outcomes(tasks.size());
  std::vector<Task> own;
  for (const auto i : of[0]) own.push_back(tasks[i]);
  auto done = host_.advance(own);
  for (std::size_t k = 0; k < own.size(); ++k) outcomes[of[0][k]] = std::move(done[k]);
  for (int r = 1; r < ranks_; ++r) {
    if (of[static_cast<std::size_t>(r)].empty()) continue;
    const std::string bytes = answer(r);
    Loader in(bytes);
    for (const auto i : of[static_cast<std::size_t>(r)]) archive_outcome(in, outcomes[i]);
  }
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    homes_.at(tasks[i].slot).cost = outcomes[i].seconds;
    if (costs_) *costs_ += fmt::format("{},{},{:.6g}\n", sweeps_, tasks[i].slot, outcomes[i].seconds);
  }
  ++sweeps_;
  return outcomes;
}

std::vector<Facts> RveFarm::commit(const std::vector<std::uint64_t>& slots) { return told(true, slots); }
std::vector<Facts> RveFarm::facts(const std::vector<std::uint64_t>& slots) { return told(false, slots); }

std::vector<Facts> RveFarm::told(bool commit, const std::vector<std::uint64_t>& slots) {
  std::vector<Facts> all(slots.size());
  std::vector<std::vector<std::size_t>> of(static_cast<std::size_t>(ranks_));
  for (std::size_t i = 0; i < slots.size(); ++i) of[static_cast<std::size_t>(homes_.at(slots[i]).rank)].push_back(i);
  for (int r = 1; r < ranks_; ++r) {
    std::vector<std::uint64_t> theirs;
    for (const auto i : of[static_cast<std::size_t>(r)]) theirs.push_back(slots[i]);
    if (!theirs.empty()) ask(r, request(commit ? Command::commit : Command::facts, theirs));
  }
  for (const auto i : of[0]) {
    if (commit) host_.commit(slots[i]);
    all[i] = host_.facts(slots[i]);
  }
  for (int r = 1; r < ranks_; ++r) {
    if (of[static_cast<std::size_t>(r)].empty()) continue;
    const std::string bytes = answer(r);
    Loader in(bytes);
    for (const auto i : of[static_cast<std::size_t>(r)]) in.plain(all[i]);
  }
  return all;
}

std::string RveFarm::fetch(std::uint64_t slot) {
  const int rank = homes_.at(slot).rank;
  if (rank == 0) return host_.hosted(slot).bytes();
  ask(rank, request(Command::fetch, {slot}));
  const std::string bytes = answer(rank);
  Loader in(bytes);
  std::string state;
  in.text(state);
  return state;
}

void RveFarm::rebalance() {
  if (ranks_ == 1 || homes_.size() < 2) return;
  std::vector<double> load(static_cast<std::size_t>(ranks_), 0);
  for (const auto& [slot, home] : homes_) load[static_cast<std::size_t>(home.rank)] += home.cost;
  const double mean = std::accumulate(load.begin(), load.end(), 0.0) / ranks_;
  for (std::size_t moves = 0; moves < homes_.size(); ++moves) {
    const auto most = std::max_element(load.begin(), load.end()), least = std::min_element(load.begin(), load.end());
    if (*most <= 1.1 * mean) return;
    // The dearest slot of the fullest rank that leaves the emptiest one below it.
    const int from = static_cast<int>(most - load.begin()), to = static_cast<int>(least - load.begin());
    auto best = homes_.end();
    for (auto h = homes_.begin(); h != homes_.end(); ++h)
      if (h->second.rank == from && *least + h->second.cost < *most && (best == homes_.end() || h->second.cost > best->second.cost)) best = h;
    if (best == homes_.end()) return;
    const std::string bytes = fetch(best->first);
    const auto slot = best->first;
    const double cost = best->second.cost;
    drop(slot);
    *most -= cost, *least += cost;
    place(to, slot, bytes, cost);
    ++moved_;
  }
}

void serve(MPI_Comm comm, std::shared_ptr<const dem::Model> model, const ResponseOptions& options, int threads) {
  RveHost host(std::move(model), options, threads);
  std::string reply;
  while (handle(host, receive(comm, 0, request_tag), reply)) send(comm, 0, answer_tag, reply);
}

}  // namespace grus::coupling
