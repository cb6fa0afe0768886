// SPDX-License-Identifier: LGPL-3.0-or-later
// The driver of a macro program's RVEs over any host: a response of all points, by no more DEM than they need.
#pragma once

#include <fmt/format.h>

#include <functional>

#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/rves/driver_book.hpp"

namespace grus::dem {

/// The one place where sharing (sharing.hpp), deferral (deferral.hpp), the measure of noise and kept tangents
/// (tangents.hpp) meet. A response: who goes with whom; copies and replays of RVEs that part; RVEs that were put off
/// and must advance now go to where they were believed to be; then every job is answered by DEM or by its last tangent.
template <Host H>
class Driver {
public:
  /// Point i starts from the state whose bytes are `prepared(start[i])`, one of so many variants. Slots are made on the
  /// host, which must outlive this.
  Driver(H& host, const std::function<std::string(std::size_t)>& prepared, std::size_t variants,
         std::span<const std::size_t> start, const RveOptions& options)
      : host_(host), book_(begin_book(start, variants, options)) {
    for (const auto& [slot, leader] : book_.sharing.leader) host_.put(slot, prepared(start[leader]), 1);
    for (std::size_t v = 0; v < variants && options.share > 0; ++v) prepared_.push_back(prepared(v));
    refresh();
  }

  /// Takes every point from its committed state through `deformation` (F_new F_old^-1, 9 a point, row by row). True:
  /// the answers are there. False: `book().reason` names the point; nothing of it is to be committed. `duration` (s) in
  /// real time; `tangent`: whether tangents will be read. What a host throws is passed on, and the next response may
  /// come.
  bool respond(std::span<const double> deformation, double duration, bool tangent, const Watch& watch = {}) {
    take_increments(book_, deformation);
    book_.reason.clear();
    try {
      find_jobs(watch);
      if (book_.reason.empty() && remembers(book_)) catch_up(watch);
      if (book_.reason.empty()) answer_jobs(duration, tangent, watch);
    } catch (...) {
      book_.now.deformation.clear();
      throw;
    }
    return conclude(book_);
  }

  /// The last response, which was true, becomes the committed states.
  void commit() {
    const std::vector<std::uint64_t> advanced = commit_jobs(book_);
    if (relaxed(book_)) take_facts(advanced, host_.commit(advanced));
    for (const std::uint64_t slot : end_increment(book_)) host_.drop(slot);
  }

  /// The answer that a point hears of the last true response, not committed; and what its RVE has done.
  const Answer& answer(std::size_t point) const { return book_.now.answer[point]; }
  const Response& response(std::size_t point) const { return book_.jobs.at(book_.plan.of.at(point)).response; }

  std::size_t points() const { return book_.sharing.point.size(); }
  std::uint64_t slot(std::size_t point) const { return book_.sharing.point.at(point).slot; }
  const Facts& facts(std::size_t point) const { return book_.slots.at(slot(point)).facts; }
  const DriverBook& book() const { return book_; }
  bool sharpen() { return dem::sharpen(book_); }
  double noise(const Joining& join = {}) { return dem::noise(book_, join); }

  /// Brings facts up to date; needed where there is no way back and steps do not tell them.
  void refresh() {
    std::vector<std::uint64_t> all;
    for (const auto& [slot, s] : book_.slots) all.push_back(slot);
    take_facts(all, host_.facts(all));
  }

  /// Drops a response that is not committed.
  void forget() {
    for (const std::uint64_t copy : forget_increment(book_)) host_.drop(copy);
  }

  /// The same, and what it has changed besides is as it was `before`.
  void forget(const BetweenIncrements& before) {
    forget();
    go_back(book_, before);
  }

  /// Puts a point where a state was taken, with what was then known of it; a response that is not committed is dropped.
  /// Not for similar sharing, where a point has a path as well. Throws InputError, and then leaves all as it was.
  void replace(std::size_t point, const std::string& state, const Memory& memory) {
    check_memory(memory);
    Sharing& sharing = book_.sharing;
    const std::uint64_t old = slot(point);
    const std::size_t n = points();
    std::size_t other = point;  // that goes on with the old RVE; the next one, as a rule
    for (std::size_t k = 1; k < n && other == point; ++k)
      if (slot((point + k) % n) == old) other = (point + k) % n;
    const std::uint64_t mine = other == point ? old : sharing.next_slot;
    host_.put(mine, state, 1);
    forget();
    if (other != point) {
      if (sharing.leader.at(old) == point) sharing.leader[old] = other;
      ++sharing.next_slot;
    }
    sharing.point[point].slot = mine, sharing.leader[mine] = point;
    book_.slots[mine].memory = memory;
    const std::vector<std::uint64_t> one{mine};
    take_facts(one, host_.facts(one));
    book_.report.distinct = book_.slots.size();
  }

  /// What messages are to call the points.
  void name_points(std::vector<std::int64_t> names) { book_.names = std::move(names); }

  /// All that decides how one point goes on, of a driver whose points have an RVE each and for good; and back, for a
  /// point of a driver that was made of the same variants. Throws InputError.
  std::string point_bytes(std::size_t point) const {
    Saver a;
    a.plain(book_.sharing.point[point].variant), a.plain(book_.sharing.point[point].total);
    archive_memory(a, book_.slots.at(slot(point)).memory);
    a.plain(book_.slots.at(slot(point)).facts);
    a.plain(!book_.kept_tangent.empty());
    if (!book_.kept_tangent.empty()) a.plain(book_.kept_tangent[point]);
    a.text(host_.fetch(slot(point)));
    return a.take();
  }
  void take_point(std::size_t point, const std::string& bytes) {
    Loader a(bytes);
    Sharing::Point& p = book_.sharing.point[point];
    DriverBook::Slot& s = book_.slots.at(p.slot);
    bool kept = false;
    std::string state;
    a.plain(p.variant), a.plain(p.total);
    archive_memory(a, s.memory);
    a.plain(s.facts);
    a.plain(kept);
    if (kept) book_.kept_tangent.resize(points()), a.plain(book_.kept_tangent[point]);
    a.text(state);
    check_memory(s.memory);
    if (!a.at_end() || p.variant >= book_.variants || !p.total.allFinite() || !(p.total.determinant() > 0) ||
        (kept && !book_.kept_tangent[point].allFinite()))
      throw InputError("checkpoint is damaged: a point and its RVE");
    host_.put(p.slot, state, static_cast<double>(s.facts.grains));
  }
  /// The count of what was done before this driver was.
  void go_on_counting(const SweepReport& from) { book_.report = from; }
  /// So many increments will have the network's tangent.
  void go_on_sharp(int increments) { book_.sharp = increments; }

  /// All that decides how the points go on: the book, then the states one by one; and back, into a driver that was made
  /// alike. Throws InputError.
  void save(const std::function<void(const std::string&)>& take) const {
    take(book_bytes(book_));
    for (const std::uint64_t slot : lasting(book_)) take(host_.fetch(slot));
  }
  void load(const std::string& bytes, std::span<const std::string> states) {
    DriverBook book = book_of(book_, bytes);
    if (states.size() != book.slots.size()) throw InputError("cut short");
    for (const auto& [slot, s] : book_.slots) host_.drop(slot);
    book_ = std::move(book);
    std::size_t k = 0;
    for (const auto& [slot, s] : book_.slots) host_.put(slot, states[k++], static_cast<double>(s.facts.grains));
  }

private:
  void take_facts(const std::vector<std::uint64_t>& slots, const std::vector<Facts>& facts) {
    for (std::size_t k = 0; k < slots.size(); ++k) book_.slots.at(slots[k]).facts = facts[k];
  }

  double cost(std::uint64_t slot) const {
    if constexpr (requires { host_.cost(slot); })
      return host_.cost(slot);
    else
      return 1;
  }

  /// For work that comes before the jobs themselves: of those, none is done.
  static Watch before(const Watch& watch) {
    return watch ? Watch([&watch](double) { return watch(0); }) : Watch{};
  }

  /// Who goes with whom, with the slots that it takes.
  void find_jobs(const Watch& watch) {
    DriverBook& b = book_;
    if (goes_alone(b)) return jobs_of_parted(b);
    b.plan = plan(b.sharing, b.now.deformation);
    auto copy = b.plan.copy.begin();
    auto again = b.plan.replay.begin();
    try {
      for (; copy != b.plan.copy.end(); ++copy) {
        host_.copy(copy->from, copy->to);
        b.slots[copy->to] = b.slots.at(copy->from);
        b.slots[copy->to].memory.trial.reset();
      }
      for (; again != b.plan.replay.end() && b.reason.empty(); ++again) replay(*again, watch);
    } catch (...) {
      for (; copy != b.plan.copy.end(); ++copy) undo(b.sharing, *copy);
      for (; again != b.plan.replay.end(); ++again) undo(b.sharing, *again);
      throw;
    }
    for (; again != b.plan.replay.end(); ++again) undo(b.sharing, *again);  // one before them has failed
    b.jobs.clear();
    for (const auto& job : b.plan.job) b.jobs.push_back({job.slot, job.leader, job.increment, false, {}});
  }

  /// The point's own path from the prepared state: its RVE from now on, whatever becomes of this increment.
  void replay(const SharingPlan::Replay& r, const Watch& watch) {
    DriverBook& b = book_;
    const std::vector<std::uint64_t> one{r.slot};
    host_.put(r.slot, prepared_[b.sharing.point[r.point].variant], cost(r.was));
    std::vector<Outcome> done;
    try {
      done = host_.advance({{r.slot, b.sharing.path[r.point], 0, Pace::relaxed, true, sharp(b)}}, before(watch));
    } catch (...) {
      host_.drop(r.slot);
      throw;
    }
    const Response& response = done[0].response;
    b.report.dem_steps += response.steps, ++b.report.replayed;
    if (!response.stable) {
      host_.drop(r.slot);
      undo(b.sharing, r);
      b.reason = fmt::format("the RVE of point {} does not get through the point's own path: {}", name(b, r.point),
                             response.failure);
      return;
    }
    b.report.sharing.add((response.stress - b.stress[r.point]).norm() / b.deferral.scale(response.stress));
    DriverBook::Slot& s = b.slots[r.slot];
    s.memory.heard = true;
    s.memory.stress = response.stress;
    s.memory.tangent = response.tangent;
    take_facts(one, host_.commit(one));
  }

  /// RVEs that must advance now and were put off: first to where the macro solver believes them to be, which measures
  /// the error.
  void catch_up(const Watch& watch) {
    DriverBook& b = book_;
    std::vector<Task> tasks;
    std::vector<std::uint64_t> slots;
    for (const DriverBook::Job& job : b.jobs) {
      const Memory& m = b.slots.at(job.slot).memory;
      if (!m.heard || m.trial || m.pending == Mat3::Identity() || b.deferral.foretells(m, job.increment)) continue;
      tasks.push_back({job.slot, {m.pending}, 0, Pace::relaxed, true, sharp(b)});
      slots.push_back(job.slot);
    }
    if (tasks.empty()) return;
    const std::vector<Outcome> done = host_.advance(tasks, before(watch));
    for (std::size_t k = 0; k < done.size(); ++k) {
      count_outcome(b.report, done[k]);
      if (done[k].response.stable) continue;
      b.reason = fmt::format("RVE of point {}, which was put off, does not get to its place: {}",
                             name(b, b.sharing.leader.at(slots[k])), done[k].response.failure);
      return;
    }
    const std::vector<Facts> facts = host_.commit(slots);
    for (std::size_t k = 0; k < done.size(); ++k) {
      DriverBook::Slot& s = b.slots.at(slots[k]);
      b.report.deferral.add(b.deferral.caught_up(s.memory, done[k].response));
      b.report.least_trust = std::min(b.report.least_trust, s.memory.trust);
      s.facts = facts[k];
    }
  }

  /// Deferral or DEM for every job.
  void answer_jobs(double duration, bool tangent, const Watch& watch) {
    DriverBook& b = book_;
    std::vector<std::size_t>& real = asked_;
    real.clear();
    tasks_.resize(b.jobs.size());
    for (std::size_t k = 0; k < b.jobs.size(); ++k) {
      DriverBook::Job& job = b.jobs[k];
      if (defer(b, job)) continue;
      if (remembers(b)) b.slots.at(job.slot).memory.trial.reset();
      Task& task = tasks_[real.size()];
      task.slot = job.slot, task.path.assign(1, job.increment), task.duration = duration;
      task.pace = b.options.pace, task.tangent = tangent, task.sharp = sharp(b);
      real.push_back(k);
    }
    tasks_.resize(real.size());
    std::vector<Outcome>& outcomes = outcomes_;
    if constexpr (requires { host_.advance(tasks_, watch, std::move(outcomes_)); })
      outcomes = host_.advance(tasks_, watch, std::move(outcomes_));
    else
      outcomes = host_.advance(tasks_, watch);
    b.report.inertial_number = 0, b.report.given_up = 0;
    for (std::size_t j = 0; j < real.size(); ++j) {
      DriverBook::Job& job = b.jobs[real[j]];
      count_outcome(b.report, outcomes[j]);
      job.response = std::move(outcomes[j].response);
      b.report.given_up += outcomes[j].given_up ? 1u : 0u;
      b.report.inertial_number += job.response.inertial_number / static_cast<double>(real.size());
      b.report.retried += job.response.pieces > 1 ? 1u : 0u;
      if (remembers(b) && job.response.stable)
        b.slots.at(job.slot).memory.trial = Memory::Trial{job.increment, job.response};
    }
    b.report.asked += b.sharing.point.size(), b.report.deferred += b.jobs.size() - real.size();
  }

  H& host_;
  std::vector<std::string> prepared_;  // bytes of the starting states; similar sharing only
  // Of the last response; room for the next, where as much memory would be taken and given back in each step.
  std::vector<Task> tasks_;
  std::vector<std::size_t> asked_;  // jobs of the tasks
  std::vector<Outcome> outcomes_;
  DriverBook book_;
};

}  // namespace grus::dem
