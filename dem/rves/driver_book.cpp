// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rves/driver_book.hpp"

#include <fmt/format.h>

#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/rves/alike.hpp"
#include "dem/rves/prediction.hpp"

namespace grus::dem {

DriverBook begin_book(std::span<const std::size_t> start, std::size_t variants, const RveOptions& options) {
  DriverBook b;
  b.options = options;
  b.deferral = {options.error, std::sqrt(3.0) * options.response.quasi_static.pressure_floor};
  b.variants = variants;
  b.sharing = begin_sharing(start, options.exact_sharing, options.share);
  for (const auto& [slot, leader] : b.sharing.leader) b.slots[slot] = {};
  b.stress.assign(options.share > 0 ? start.size() : 0, Mat3::Zero());
  b.report.distinct = b.slots.size();
  return b;
}

void take_increments(DriverBook& b, std::span<const double> deformation) {
  std::swap(b.before, b.now);
  const std::size_t n = b.sharing.point.size();
  b.now.deformation.resize(n), b.now.answer.resize(n);
  const bool together = relaxed(b) || (b.options.pace == Pace::steady && !parted(b.sharing));
  Alike alike;
  for (std::size_t i = 0; i < n; ++i) {
    b.now.deformation[i] = snapped(deformation.subspan(9 * i, 9));
    if (together) b.now.deformation[i] = alike(b.now.deformation[i]);
  }
}

void jobs_of_parted(DriverBook& b) {
  if (!b.plan.apart) std::swap(b.plan, b.last_plan), std::swap(b.jobs, b.last_jobs);
  plan_parted(b.sharing, b.now.deformation, b.plan);
  b.jobs.resize(b.plan.job.size());
  for (std::size_t k = 0; k < b.jobs.size(); ++k) {  // the response will be replaced
    const SharingPlan::Job& from = b.plan.job[k];
    DriverBook::Job& job = b.jobs[k];
    if (!job.facts || job.slot != from.slot) job.facts = &b.slots.at(from.slot).facts;
    job.slot = from.slot, job.leader = from.leader, job.increment = from.increment;
  }
}

void count_outcome(SweepReport& report, const Outcome& outcome) {
  ++(outcome.elastic ? report.elastic : report.advanced);
  report.dem_steps += outcome.response.steps;
  if (outcome.elastic_error >= 0) report.linear.add(outcome.elastic_error);
}

bool defer(const DriverBook& b, DriverBook::Job& job) {
  if (!remembers(b)) return false;
  const Memory& m = b.slots.at(job.slot).memory;
  if (!b.deferral.foretells(m, job.increment)) return false;
  // What has done DEM in this increment answers from there, not from its start.
  const Told last = told(m, job.increment);
  job.deferred = true;
  if (m.trial) job.response = m.trial->response;
  job.response.stress = predicted(last.stress, last.tangent, last.beyond);
  job.response.tangent = last.tangent, job.response.stable = true;
  return true;
}

namespace {

/// What a point hears of its job: for one that rides on another's path, to first order in the difference.
Answer corrected(DriverBook& b, std::size_t i, const DriverBook::Job& job) {
  const Sharing::Point &mine = b.sharing.point[i], &leader = b.sharing.point[job.leader];
  const Response& r = job.response;
  if (job.leader == i || (b.now.deformation[i] == job.increment && mine.total == leader.total))
    return {r.stress, r.tangent, r.breakages};
  const Mat3 difference = b.now.deformation[i] * mine.total * (job.increment * leader.total).inverse();
  const Mat3 stress = predicted(r.stress, r.tangent, difference);
  ++b.report.similar;
  b.report.correction = std::max(b.report.correction, (stress - r.stress).norm() / b.deferral.scale(stress));
  return {stress, r.tangent, r.breakages};
}

}  // namespace

bool conclude(DriverBook& b) {
  for (const DriverBook::Job& job : b.jobs)
    if (!job.response.stable && b.reason.empty())
      b.reason = fmt::format("RVE of point {}: {}", name(b, job.leader), job.response.failure);
  if (!b.reason.empty()) {
    b.now.deformation.clear();  // nothing to compare the next response with
    return false;
  }
  for (std::size_t i = 0; i < b.now.answer.size(); ++i) b.now.answer[i] = corrected(b, i, b.jobs[b.plan.of[i]]);
  choose_tangents(b.options.response.tangent, b.before, b.now, b.kept_tangent);
  return true;
}

std::vector<std::uint64_t> commit_jobs(DriverBook& b) {
  b.report.worst_unbalanced = b.report.worst_stress_change = 0;
  std::vector<std::uint64_t> advanced;
  for (const DriverBook::Job& job : b.jobs) {
    const Response* done = &job.response;
    if (remembers(b)) done = commit(b.slots.at(job.slot).memory, job.increment, job.deferred, job.response);
    if (done) {
      if (relaxed(b)) advanced.push_back(job.slot);
      b.report.worst_unbalanced = std::max(b.report.worst_unbalanced, done->unbalanced_force);
      b.report.worst_stress_change = std::max(b.report.worst_stress_change, done->stress_change);
    }
    if (relaxed(b)) continue;
    Facts& facts = job.facts ? *job.facts : b.slots.at(job.slot).facts;
    facts.work = job.response.work, facts.haste = job.response.haste;
  }
  return advanced;
}

std::vector<std::uint64_t> end_increment(DriverBook& b) {
  std::vector<std::uint64_t> unused = commit(b.sharing, b.plan, b.now.deformation);
  for (const std::uint64_t slot : unused) b.slots.erase(slot);
  for (std::size_t i = 0; i < b.stress.size(); ++i) b.stress[i] = b.now.answer[i].stress;
  if (remembers(b))
    for (auto& [slot, s] : b.slots) s.memory.trial.reset();
  if (b.plan.apart) std::swap(b.plan, b.last_plan), std::swap(b.jobs, b.last_jobs);
  b.jobs.clear(), b.plan = {};
  b.sharp = std::max(0, b.sharp - 1);
  b.now.deformation.clear();  // the next response starts another increment
  b.report.distinct = b.slots.size();
  return unused;
}

std::vector<std::uint64_t> forget_increment(DriverBook& b) {
  std::vector<std::uint64_t> unused;
  for (const auto& [slot, copies] : b.sharing.copies) unused.insert(unused.end(), copies.begin(), copies.end());
  for (const std::uint64_t copy : unused) b.sharing.leader.erase(copy), b.slots.erase(copy);
  b.sharing.copies.clear();
  for (auto& [slot, s] : b.slots) s.memory.trial.reset();
  b.jobs.clear(), b.plan = {};
  b.now.deformation.clear();
  return unused;
}

BetweenIncrements between_increments(const DriverBook& b) {
  return {b.sharing.next_slot, b.kept_tangent, b.sharp, b.report};
}

void go_back(DriverBook& b, const BetweenIncrements& before) {
  b.sharing.next_slot = before.next_slot, b.kept_tangent = before.kept_tangent;
  b.sharp = before.sharp, b.report = before.report;
}

bool sharpen(DriverBook& b) {
  constexpr int lasting = 5;  // increments; a stall comes seldom alone
  if (b.options.response.tangent != TangentKind::automatic || b.sharp > 0) return false;
  b.sharp = lasting;
  for (auto& [slot, s] : b.slots) s.memory.trial.reset();
  return true;
}

double noise(DriverBook& b, const Joining& join) {
  b.noise.read(b.before, b.now, join);
  const QuasiStatic& q = b.options.response.quasi_static;
  return std::max({q.unbalanced_force, q.stress_change, std::min(b.noise.measured, max_noise)});
}

std::vector<std::uint64_t> lasting(const DriverBook& b) {
  std::vector<std::uint64_t> slots;
  for (const auto& [slot, leader] : b.sharing.leader)
    if (b.sharing.point[leader].slot == slot) slots.push_back(slot);
  return slots;
}

namespace {

/// Archives a book apart from its slots.
template <class A>
void archive_points(A& a, auto& b) {
  a.column(b.sharing.point), a.plain(b.sharing.next_slot);
  for (auto& p : b.sharing.path) a.column(p);
  a.column(b.stress);
  a.column(b.kept_tangent);
  a.plain(b.sharp);
  a.plain(b.report);
}

}  // namespace

std::string book_bytes(const DriverBook& b) {
  Saver a;
  a.plain(b.sharing.point.size()), a.plain(b.sharing.path.size());
  archive_points(a, b);
  const std::vector<std::uint64_t> slots = lasting(b);
  a.plain(slots.size());
  for (const std::uint64_t slot : slots) {
    a.plain(slot), a.plain(b.sharing.leader.at(slot));
    archive_memory(a, b.slots.at(slot).memory);
    a.plain(b.slots.at(slot).facts);
  }
  return a.take();
}

void check_memory(const Memory& m) {
  if (!m.pending.allFinite() || m.pending.determinant() <= 0 || !m.stress.allFinite() || !m.tangent.allFinite() ||
      !std::isfinite(m.trust))
    throw InputError("damaged: what is known of the RVEs");
}

DriverBook book_of(const DriverBook& own, const std::string& bytes) {
  Loader a(bytes);
  std::size_t points = 0, paths = 0, slots = 0;
  a.plain(points), a.plain(paths);
  if (points != own.sharing.point.size())
    throw InputError(fmt::format("of {} points, where there are {}", points, own.sharing.point.size()));
  if (paths != own.sharing.path.size()) throw InputError("of other adaptivity");
  DriverBook b;
  b.options = own.options, b.deferral = own.deferral, b.variants = own.variants, b.names = own.names;
  b.sharing.tolerance = own.sharing.tolerance;
  b.sharing.path.resize(paths);
  archive_points(a, b);
  a.plain(slots);
  for (std::size_t k = 0; k < slots; ++k) {
    std::uint64_t slot = 0;
    a.plain(slot), a.plain(b.sharing.leader[slot]);
    DriverBook::Slot& s = b.slots[slot];
    archive_memory(a, s.memory);
    a.plain(s.facts);
    check_memory(s.memory);
  }
  check_sharing(b.sharing, b.sharing.leader, paths > 0 ? b.variants : SIZE_MAX);
  bool good = a.at_end() && b.sharing.point.size() == points && b.stress.size() == own.stress.size() &&
              (b.kept_tangent.empty() || b.kept_tangent.size() == points) && b.sharp >= 0;
  for (const Mat3& stress : b.stress) good = good && stress.allFinite();
  for (const Mat6& tangent : b.kept_tangent) good = good && tangent.allFinite();
  if (!good) throw InputError("damaged: what is known of the RVEs");
  return b;
}

}  // namespace grus::dem
