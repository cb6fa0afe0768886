// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/rve_farm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "dem/base/clock.hpp"
#include "dem/base/fault.hpp"
#include "dem/io/archive.hpp"

namespace grus::coupling {
namespace {

using dem::Loader;
using dem::Saver;

enum class Command : std::uint8_t { put, copy, drop, advance, commit, facts, fetch, stop };
constexpr int request_tag = 1, answer_tag = 2;

constexpr std::uint64_t piece = 1u << 24;  // of a message: a count is an int, and states of many grains may be large

void send(MPI_Comm comm, int rank, int tag, const std::string& bytes) {
  const std::uint64_t size = bytes.size();
  MPI_Send(&size, 1, MPI_UINT64_T, rank, tag, comm);
  for (std::uint64_t at = 0; at < size; at += piece)
    MPI_Send(bytes.data() + at, static_cast<int>(std::min(size - at, piece)), MPI_CHAR, rank, tag, comm);
}

std::string receive(MPI_Comm comm, int rank, int tag) {
  std::uint64_t size = 0;
  MPI_Recv(&size, 1, MPI_UINT64_T, rank, tag, comm, MPI_STATUS_IGNORE);
  std::string bytes;
  try {
    bytes.resize(size);
  } catch (const std::bad_alloc&) {  // the message must leave all the same, or the next one would be read amiss
    std::string bin(piece, '\0');
    for (std::uint64_t at = 0; at < size; at += piece)
      MPI_Recv(bin.data(), static_cast<int>(std::min(size - at, piece)), MPI_CHAR, rank, tag, comm, MPI_STATUS_IGNORE);
    throw;
  }
  for (std::uint64_t at = 0; at < size; at += piece)
    MPI_Recv(bytes.data() + at, static_cast<int>(std::min(size - at, piece)), MPI_CHAR, rank, tag, comm,
             MPI_STATUS_IGNORE);
  return bytes;
}

template <class A, class T>
void archive_task(A& a, T& t) {
  a.plain(t.slot);
  a.column(t.path);
  a.plain(t.duration);
  a.plain(t.pace);
  a.plain(t.tangent);
  a.plain(t.sharp);
}

/// The tangent, more than half of the bytes, crosses where it was asked for.
template <class A, class O>
void archive_outcome(A& a, O& o, bool tangent) {
  auto& r = o.response;
  a.plain(r.stress);
  if (tangent) a.plain(r.tangent);
  a.plain(r.stable);
  a.plain(r.unbalanced_force);
  a.plain(r.stress_change);
  a.plain(r.steps);
  a.plain(r.hold_steps);
  a.plain(r.breakages);
  a.plain(r.pieces);
  a.plain(r.work);
  a.plain(r.haste);
  a.plain(r.inertial_number);
  a.text(r.failure);
  a.plain(r.tangent_seconds);
  a.plain(o.seconds);
  a.plain(o.elastic);
  a.plain(o.given_up);
  a.plain(o.elastic_error);
}

int size_of(MPI_Comm comm) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  return ranks;
}

std::string request(Command c, const std::vector<std::uint64_t>& slots) {
  Saver s;
  s.plain(c), s.column(slots);
  return s.take();
}

bool is_stop(const std::string& bytes) {
  return !bytes.empty() && static_cast<Command>(bytes.front()) == Command::stop;
}

/// The answer to one request on the rank that it came to.
std::string handle(dem::RveHost& host, const std::string& bytes) {
  Loader in(bytes);
  Saver out;
  Command c;
  std::vector<std::uint64_t> slots;
  in.plain(c), in.column(slots);
  switch (c) {
    case Command::stop:
      break;
    case Command::put: {
      std::string state;
      in.text(state);
      host.put(slots[0], state, 1);
      break;
    }
    case Command::copy:
      host.copy(slots[0], slots[1]);
      break;
    case Command::drop:
      host.drop(slots[0]);
      break;
    case Command::advance: {
      std::vector<dem::Task> tasks(slots.size());
      for (dem::Task& t : tasks) archive_task(in, t);
      const std::vector<dem::Outcome> outcomes = host.advance(tasks);
      for (std::size_t i = 0; i < tasks.size(); ++i) archive_outcome(out, outcomes[i], tasks[i].tangent);
      break;
    }
    case Command::commit:
    case Command::facts:
      for (const dem::Facts& f : c == Command::commit ? host.commit(slots) : host.facts(slots)) out.plain(f);
      break;
    case Command::fetch:
      out.text(host.fetch(slots[0]));
      break;
  }
  return out.take();
}

}  // namespace

RveFarm::RveFarm(MPI_Comm comm, std::shared_ptr<const dem::Model> model, const dem::ResponseOptions& options,
                 int threads) try
    : comm_(comm), ranks_(size_of(comm)), host_(std::move(model), options, threads), loads_(ranks_) {
  owed_.assign(static_cast<std::size_t>(ranks_), 0);
} catch (...) {  // no destructor will: the other ranks are told to go all the same
  for (int r = 1; r < size_of(comm); ++r) send(comm, r, request_tag, request(Command::stop, {}));
}

RveFarm::~RveFarm() {
  for (int r = 1; r < ranks_; ++r) {
    drain(r);
    send(comm_, r, request_tag, request(Command::stop, {}));
  }
}

/// Takes answers that nobody has waited for, because something failed between asking and listening: a rank that still
/// wants to tell one hears nothing.
void RveFarm::drain(int rank) {
  for (int& owed = owed_[static_cast<std::size_t>(rank)]; owed > 0; --owed) receive(comm_, rank, answer_tag);
}

void RveFarm::ask(int rank, const std::string& bytes) {
  drain(rank);
  send(comm_, rank, request_tag, bytes);
  sent_ += bytes.size();
  ++owed_[static_cast<std::size_t>(rank)];
}

std::string RveFarm::answer(int rank) {
  --owed_[static_cast<std::size_t>(rank)];
  std::string bytes = receive(comm_, rank, answer_tag);
  received_ += bytes.size();
  if (bytes.empty()) bytes = dem::Fault{dem::Fault::Kind::memory, "out of memory"}.bytes();  // none left to say so
  if (bytes.front() != 'a') rethrow(on_rank(rank, dem::Fault::of(bytes)));
  return bytes.substr(1);
}

/// A slot that was put somewhere lives there from now on.
void RveFarm::settle(std::uint64_t slot, int rank, double cost) {
  if (const auto old = homes_.find(slot); old != homes_.end()) loads_.add(old->second.rank, -old->second.cost);
  homes_[slot] = {rank, cost};
  loads_.add(rank, cost);
}

void RveFarm::put(std::uint64_t slot, const dem::State& state, double cost) {
  if (loads_.idlest() == 0) {
    host_.put(slot, {.state = state});
    settle(slot, 0, cost);
  } else {
    put(slot, dem::HostedRve{.state = state}.bytes(), cost);
  }
}

void RveFarm::put(std::uint64_t slot, const std::string& state, double cost) {
  place(loads_.idlest(), slot, state, cost);
}

void RveFarm::place(int rank, std::uint64_t slot, const std::string& state, double cost) {
  if (rank == 0) {
    host_.put(slot, state, cost);
    return settle(slot, rank, cost);
  }
  Saver s;
  s.plain(Command::put), s.column(std::vector<std::uint64_t>{slot}), s.text(state);
  ask(rank, s.take());
  answer(rank);
  settle(slot, rank, cost);
}

void RveFarm::copy(std::uint64_t from, std::uint64_t to) {
  const Home home = homes_.at(from);
  const int rank = loads_.idlest();
  if (rank != home.rank) return place(rank, to, fetch(from), home.cost);
  settle(to, rank, home.cost);
  if (rank == 0) return host_.copy(from, to);
  ask(rank, request(Command::copy, {from, to}));
  answer(rank);
}

void RveFarm::drop(std::uint64_t slot) {
  const int rank = homes_.at(slot).rank;
  loads_.add(rank, -homes_.at(slot).cost);
  homes_.erase(slot);
  if (rank == 0) return host_.drop(slot);
  ask(rank, request(Command::drop, {slot}));
  answer(rank);
}

std::int64_t RveFarm::called(std::uint64_t slot) const {
  const auto at = called_.find(slot);
  return at == called_.end() ? static_cast<std::int64_t>(slot) : at->second;
}

/// Tasks on the ranks where their RVEs live; `telling`: of each rank s a task to tell it and to read its answer.
std::vector<dem::Outcome> RveFarm::advance_on_ranks(const std::vector<dem::Task>& tasks, const dem::Watch& watch,
                                                    std::vector<double>& telling) {
  std::vector<std::vector<std::size_t>> of(static_cast<std::size_t>(ranks_));
  for (std::size_t i = 0; i < tasks.size(); ++i)
    of[static_cast<std::size_t>(homes_.at(tasks[i].slot).rank)].push_back(i);
  for (int r = 1; r < ranks_; ++r) {
    const auto& mine = of[static_cast<std::size_t>(r)];
    if (mine.empty()) continue;
    const dem::Clock clock;
    Saver s;
    std::vector<std::uint64_t> slots;
    for (const auto i : mine) slots.push_back(tasks[i].slot);
    s.plain(Command::advance), s.column(slots);
    for (const auto i : mine) archive_task(s, tasks[i]);
    ask(r, s.take());
    telling[static_cast<std::size_t>(r)] = clock.wall();
  }
  std::vector<dem::Outcome> outcomes(tasks.size());
  std::vector<dem::Task> own;
  for (const auto i : of[0]) own.push_back(tasks[i]);
  auto done = host_.advance(own, watch);
  for (std::size_t k = 0; k < own.size(); ++k) outcomes[of[0][k]] = std::move(done[k]);
  for (int r = 1; r < ranks_; ++r) {
    const auto& mine = of[static_cast<std::size_t>(r)];
    if (mine.empty()) continue;
    const std::string bytes = answer(r);
    const dem::Clock clock;
    Loader in(bytes);
    for (const auto i : mine) archive_outcome(in, outcomes[i], tasks[i].tangent);
    double& told = telling[static_cast<std::size_t>(r)];
    told = (told + clock.wall()) / static_cast<double>(mine.size());
  }
  return outcomes;
}

std::vector<dem::Outcome> RveFarm::advance(const std::vector<dem::Task>& tasks, const dem::Watch& watch,
                                           std::vector<dem::Outcome> room) {
  std::vector<double> telling(static_cast<std::size_t>(ranks_), 0);
  std::vector<dem::Outcome> outcomes =
      ranks_ == 1 ? host_.advance(tasks, watch, std::move(room)) : advance_on_ranks(tasks, watch, telling);
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    Home& home = homes_.at(tasks[i].slot);
    home.spent += outcomes[i].seconds;
    if (costs_)
      *costs_ += fmt::format("{},{},{},{:.6g},{:.6g},{},{:.6g}\n", sweeps_, called(tasks[i].slot), home.rank + rank_,
                             outcomes[i].seconds, outcomes[i].response.tangent_seconds, outcomes[i].response.steps,
                             telling[static_cast<std::size_t>(home.rank)]);
  }
  ++sweeps_;
  return outcomes;
}

std::vector<dem::Facts> RveFarm::commit(const std::vector<std::uint64_t>& slots) { return told(true, slots); }
std::vector<dem::Facts> RveFarm::facts(const std::vector<std::uint64_t>& slots) { return told(false, slots); }

std::vector<dem::Facts> RveFarm::told(bool commit, const std::vector<std::uint64_t>& slots) {
  if (ranks_ == 1) return commit ? host_.commit(slots) : host_.facts(slots);
  std::vector<dem::Facts> all(slots.size());
  std::vector<std::vector<std::size_t>> of(static_cast<std::size_t>(ranks_));
  for (std::size_t i = 0; i < slots.size(); ++i) of[static_cast<std::size_t>(homes_.at(slots[i]).rank)].push_back(i);
  for (int r = 1; r < ranks_; ++r) {
    std::vector<std::uint64_t> theirs;
    for (const auto i : of[static_cast<std::size_t>(r)]) theirs.push_back(slots[i]);
    if (!theirs.empty()) ask(r, request(commit ? Command::commit : Command::facts, theirs));
  }
  std::vector<std::uint64_t> own;
  for (const auto i : of[0]) own.push_back(slots[i]);
  const std::vector<dem::Facts> here = commit ? host_.commit(own) : host_.facts(own);
  for (std::size_t k = 0; k < own.size(); ++k) all[of[0][k]] = here[k];
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
  if (rank == 0) return host_.fetch(slot);
  ask(rank, request(Command::fetch, {slot}));
  const std::string bytes = answer(rank);
  Loader in(bytes);
  std::string state;
  in.text(state);
  return state;
}

void RveFarm::rebalance() {
  if (ranks_ == 1 || homes_.size() < 2) return;
  std::vector<Lodger> lodgers;
  loads_ = Loads(ranks_);
  for (auto& [slot, home] : homes_) {
    if (home.spent > 0) home.cost = std::exchange(home.spent, 0.0);
    lodgers.push_back({slot, home.rank, home.cost});
  }
  std::sort(lodgers.begin(), lodgers.end(), [](const Lodger& a, const Lodger& b) { return a.slot < b.slot; });
  for (const Lodger& l : lodgers) loads_.add(l.rank, l.cost);
  for (const Move& move : moves_to_balance(lodgers, ranks_)) {
    const std::string bytes = fetch(move.slot);
    const double cost = homes_.at(move.slot).cost;
    drop(move.slot);
    place(move.to, move.slot, bytes, cost);
    ++moved_;
  }
}

void serve(MPI_Comm comm, const std::shared_ptr<const dem::Model>& model, const dem::ResponseOptions& options,
           int threads) {
  // Whatever fails here is an answer: rank 0 waits for one. It begins with an a, or it is a fault's bytes.
  std::optional<dem::RveHost> host;
  while (true) {
    std::string reply;
    try {
      const std::string bytes = receive(comm, 0, request_tag);
      if (is_stop(bytes)) return;
      if (!host) host.emplace(model, options, threads);
      reply = std::string("a").append(handle(*host, bytes));  // g++ 12 takes "a" + ... for an overlap
    } catch (...) {
      reply = dem::caught().bytes();
    }
    send(comm, 0, answer_tag, reply);
  }
}

}  // namespace grus::coupling
