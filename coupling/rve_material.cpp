// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/rve_material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/rve/steady.hpp"
#include "dem/rves/alike.hpp"
#include "dem/rves/prediction.hpp"

namespace grus::coupling {

using dem::Facts;
using dem::HostedRve;
using dem::Mat3;
using dem::Mat6;
using dem::Outcome;
using dem::Pace;
using dem::Task;

RveMaterial::RveMaterial(RveFarm& farm, const std::vector<dem::State>& states, const std::vector<std::size_t>& start,
                         const RveOptions& options)
    : farm_(farm),
      options_(options),
      deferral_{options.error, std::sqrt(3.0) * options.response.quasi_static.pressure_floor},
      sharing_(dem::begin_sharing(start, options.exact_sharing, options.share)) {
  for (const auto& [slot, leader] : sharing_.leader) {
    farm_.put(slot, states[start[leader]], 1);
    slots_[slot] = {};
  }
  for (const auto& s : states) start_volume_.push_back(s.boundary.cell.volume());
  if (options_.share > 0)
    for (const auto& s : states) prepared_.push_back(HostedRve{.state = s}.bytes());
  stress_.assign(options_.share > 0 ? start.size() : 0, Mat3::Zero());
  refresh();
  report_.distinct = slots_.size();
}

fem::Material RveMaterial::material() {
  auto packed = [this] {
    dem::Saver a;
    save([&](const std::string& part) { a.text(part); });
    return a.take();
  };
  auto unpacked = [this](const std::string& bytes) {
    std::vector<std::string> parts;
    for (dem::Loader a(bytes); !a.at_end();) a.text(parts.emplace_back());
    load(parts);
  };
  auto energy = [this](std::span<const double> volumes) {
    return total(&Facts::work, volumes) - total(&Facts::haste, volumes);
  };
  fem::Material m([this](const fem::Points& p) { return respond(p); }, [this] { commit(); }, packed, unpacked, energy);
  m.noise = [this] { return noise(); };
  m.sharpen = [this] { return sharpen(); };
  m.inertial_number = [this] { return report_.inertial_number; };
  m.reason = [this] { return reason_; };
  return m;
}

double RveMaterial::total(Facts::Number energy, std::span<const double> volumes) const {
  double sum = 0;
  for (std::size_t i = 0; i < volumes.size(); ++i) sum += facts(i).*energy * volumes[i] / start_volume(i);
  return sum;
}

dem::State RveMaterial::committed(std::size_t point) const {
  HostedRve rve = HostedRve::from(farm_.fetch(sharing_.point[point].slot));
  return dem::in_space(farm_.whole(std::move(rve.state)), rve.steady);
}

void RveMaterial::refresh() {
  std::vector<std::uint64_t> all;
  for (const auto& [slot, s] : slots_) all.push_back(slot);
  const std::vector<Facts> facts = farm_.facts(all);
  for (std::size_t k = 0; k < all.size(); ++k) slots_[all[k]].facts = facts[k];
}

double RveMaterial::noise() {
  noise_.read(before_, now_);
  const dem::QuasiStatic& q = options_.response.quasi_static;
  return std::max({q.unbalanced_force, q.stress_change, std::min(noise_.measured, max_noise)});
}

bool RveMaterial::sharpen() {
  constexpr int lasting = 5;  // increments; a stall comes seldom alone
  if (options_.response.tangent != dem::TangentKind::automatic || sharp_ > 0) return false;
  sharp_ = lasting;
  for (auto& [slot, s] : slots_) s.memory.trial.reset();
  return true;
}

/// What the points are told, taken to a grid; alike where grains will do the same.
void RveMaterial::take_increments(const fem::Points& points) {
  std::swap(before_, now_);
  now_.deformation.resize(sharing_.point.size()), now_.answer.resize(sharing_.point.size());
  dem::Alike alike;
  for (std::size_t i = 0; i < now_.deformation.size(); ++i) {
    now_.deformation[i] = dem::snapped(points.deformation.subspan(9 * i, 9));
    if (relaxed() || (options_.pace == Pace::steady && !parted(sharing_)))
      now_.deformation[i] = alike(now_.deformation[i]);
  }
}

bool RveMaterial::respond(const fem::Points& points) {
  const auto begin = std::chrono::steady_clock::now();
  take_increments(points);
  reason_.clear();
  find_jobs();
  if (reason_.empty() && options_.error > 0) catch_up();
  if (reason_.empty()) answer(points.duration, !points.tangent.empty());
  for (const Job& job : jobs_)
    if (!job.response.stable && reason_.empty())
      reason_ = fmt::format("RVE of point {}: {}", job.leader, job.response.failure);
  const bool good = reason_.empty();
  if (good) {
    for (std::size_t i = 0; i < now_.answer.size(); ++i) now_.answer[i] = corrected(i, jobs_[plan_.of[i]]);
    choose_tangents(options_.response.tangent, before_, now_, kept_tangent_);
    hand_over(points);
  } else {
    now_.deformation.clear();  // nothing to compare the next response with
  }
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return good;
}

void RveMaterial::hand_over(const fem::Points& points) const {
  for (std::size_t i = 0; i < now_.answer.size(); ++i) {
    const Answer& r = now_.answer[i];
    const dem::Vec6 stress = dem::to_voigt(r.stress);
    for (int k = 0; k < 6; ++k) points.stress[6 * i + static_cast<std::size_t>(k)] = stress[k];
    if (points.tangent.empty()) continue;
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) points.tangent[36 * i + static_cast<std::size_t>(6 * a + b)] = r.tangent(a, b);
  }
}

/// Who goes with whom, with the slots that it takes.
void RveMaterial::find_jobs() {
  const bool apart = !relaxed() && parted(sharing_);
  plan_ = apart ? plan_parted(sharing_, now_.deformation) : plan(sharing_, now_.deformation);
  for (const auto& copy : plan_.copy) {
    farm_.copy(copy.from, copy.to);
    slots_[copy.to] = slots_.at(copy.from);
    slots_[copy.to].memory.trial.reset();
  }
  for (const auto& r : plan_.replay) replay(r);
  jobs_.clear();
  for (const auto& job : plan_.job) jobs_.push_back({job.slot, job.leader, job.increment, false, {}});
}

/// The point's own path from the prepared state: its RVE from now on, whatever becomes of this increment.
void RveMaterial::replay(const dem::SharingPlan::Replay& r) {
  if (!reason_.empty()) return undo(sharing_, r);  // one before it has failed
  farm_.put_bytes(r.slot, prepared_[sharing_.point[r.point].variant], farm_.cost(r.was));
  const std::vector<Outcome> done = farm_.advance({{r.slot, sharing_.path[r.point], 0, Pace::relaxed, true, sharp()}});
  const dem::Response& response = done[0].response;
  report_.dem_steps += response.steps, ++report_.replayed;
  if (!response.stable) {
    farm_.drop(r.slot);
    undo(sharing_, r);
    reason_ =
        fmt::format("the RVE of point {} does not get through the point's own path: {}", r.point, response.failure);
    return;
  }
  report_.sharing.add((response.stress - stress_[r.point]).norm() / deferral_.scale(response.stress));
  Slot& s = slots_[r.slot];
  s.memory.heard = true;
  s.memory.stress = response.stress;
  s.memory.tangent = response.tangent;
  s.facts = farm_.commit({r.slot})[0];
}

/// RVEs that must advance now and were put off: first to where the macro solver believes them to be, which measures the
/// error.
void RveMaterial::catch_up() {
  std::vector<Task> tasks;
  std::vector<std::uint64_t> slots;
  for (const Job& job : jobs_) {
    const Memory& m = slots_.at(job.slot).memory;
    if (!m.heard || m.trial || m.pending == Mat3::Identity() || deferral_.foretells(m, job.increment)) continue;
    tasks.push_back({job.slot, {m.pending}, 0, Pace::relaxed, true, sharp()});
    slots.push_back(job.slot);
  }
  if (tasks.empty()) return;
  const std::vector<Outcome> done = farm_.advance(tasks);
  for (std::size_t k = 0; k < done.size(); ++k) {
    const dem::Response& r = done[k].response;
    report_.dem_steps += r.steps, ++(done[k].elastic ? report_.elastic : report_.advanced);
    if (done[k].elastic_error >= 0) report_.linear.add(done[k].elastic_error);
    if (r.stable) continue;
    const std::size_t leader = sharing_.leader.at(slots[k]);
    reason_ = fmt::format("RVE of point {}, which was put off, does not get to its place: {}", leader, r.failure);
    return;
  }
  const std::vector<Facts> facts = farm_.commit(slots);
  for (std::size_t k = 0; k < done.size(); ++k) {
    Slot& s = slots_.at(slots[k]);
    report_.deferral.add(deferral_.caught_up(s.memory, done[k].response));
    report_.least_trust = std::min(report_.least_trust, s.memory.trust);
    s.facts = facts[k];
  }
}

/// Deferral or DEM for every job.
void RveMaterial::answer(double duration, bool tangent) {
  std::vector<Task> tasks;
  std::vector<std::size_t> real;
  for (std::size_t k = 0; k < jobs_.size(); ++k) {
    Job& job = jobs_[k];
    Memory& m = slots_.at(job.slot).memory;
    // What has done DEM in this increment answers from there, not from its start.
    if (deferral_.foretells(m, job.increment)) {
      const Told last = told(m, job.increment);
      job.deferred = true;
      if (m.trial) job.response = m.trial->response;
      job.response.stress = dem::predicted(last.stress, last.tangent, last.beyond);
      job.response.tangent = last.tangent, job.response.stable = true;
      continue;
    }
    m.trial.reset();
    real.push_back(k);
    tasks.push_back({job.slot, {job.increment}, duration, options_.pace, tangent, sharp()});
  }
  std::vector<Outcome> outcomes = farm_.advance(tasks);
  report_.inertial_number = 0, report_.given_up = 0;
  for (std::size_t j = 0; j < real.size(); ++j) {
    Job& job = jobs_[real[j]];
    job.response = std::move(outcomes[j].response);
    ++(outcomes[j].elastic ? report_.elastic : report_.advanced);
    if (outcomes[j].elastic_error >= 0) report_.linear.add(outcomes[j].elastic_error);
    report_.given_up += outcomes[j].given_up ? 1u : 0u;
    report_.inertial_number += job.response.inertial_number / static_cast<double>(real.size());
    report_.dem_steps += job.response.steps;
    report_.retried += job.response.pieces > 1 ? 1u : 0u;
    if (options_.error > 0 && job.response.stable)
      slots_.at(job.slot).memory.trial = Memory::Trial{job.increment, job.response};
  }
  report_.asked += sharing_.point.size(), report_.deferred += jobs_.size() - real.size();
}

/// What a point hears of its job: for one that rides on another's path, to first order in the difference.
Answer RveMaterial::corrected(std::size_t i, const Job& job) {
  const dem::Sharing::Point &mine = sharing_.point[i], &leader = sharing_.point[job.leader];
  const dem::Response& r = job.response;
  if (job.leader == i || (now_.deformation[i] == job.increment && mine.total == leader.total))
    return {r.stress, r.tangent, r.breakages};
  const Mat3 difference = now_.deformation[i] * mine.total * (job.increment * leader.total).inverse();
  const Mat3 stress = dem::predicted(r.stress, r.tangent, difference);
  ++report_.similar;
  report_.correction = std::max(report_.correction, (stress - r.stress).norm() / deferral_.scale(stress));
  return {stress, r.tangent, r.breakages};
}

void RveMaterial::commit() {
  report_.worst_unbalanced = report_.worst_stress_change = 0;
  std::vector<std::uint64_t> advanced;
  for (const Job& job : jobs_) {
    const dem::Response* done = coupling::commit(slots_.at(job.slot).memory, job.increment, job.deferred, job.response);
    if (!done) continue;
    advanced.push_back(job.slot);
    report_.worst_unbalanced = std::max(report_.worst_unbalanced, done->unbalanced_force);
    report_.worst_stress_change = std::max(report_.worst_stress_change, done->stress_change);
  }
  if (!relaxed()) {
    for (const Job& job : jobs_) {
      Facts& facts = slots_.at(job.slot).facts;
      facts.work = job.response.work, facts.haste = job.response.haste;
    }
  } else {
    const std::vector<Facts> facts = farm_.commit(advanced);
    for (std::size_t k = 0; k < advanced.size(); ++k) slots_.at(advanced[k]).facts = facts[k];
  }
  for (const std::uint64_t slot : dem::commit(sharing_, plan_, now_.deformation)) farm_.drop(slot), slots_.erase(slot);
  for (std::size_t i = 0; i < stress_.size(); ++i) stress_[i] = now_.answer[i].stress;
  for (auto& [slot, s] : slots_) s.memory.trial.reset();
  jobs_.clear(), plan_ = {};
  sharp_ = std::max(0, sharp_ - 1);
  now_.deformation.clear();  // the next response starts another increment
  report_.distinct = slots_.size();
  // An explicit step is too short to go by, and too cheap to pay for a move.
  constexpr std::uint64_t steps_between = 100;
  if (relaxed() || ++commits_ % steps_between == 0) farm_.rebalance();
}

std::uint64_t RveMaterial::count(dem::Facts::Count what) const {
  std::uint64_t sum = 0;
  for (const auto& p : sharing_.point) sum += slots_.at(p.slot).facts.*what;
  return sum;
}

namespace {

template <class A, class M>
void archive_map(A& a, M& map, auto&& one) {
  std::uint64_t n = map.size();
  a.plain(n);
  if constexpr (std::is_const_v<M>) {
    for (const auto& [key, value] : map) a.plain(key), one(value);
  } else {
    map.clear();
    for (std::uint64_t k = 0, key; k < n; ++k) a.plain(key), one(map[key]);
  }
}

}  // namespace

template <class A>
void RveMaterial::archive(A& a, auto& m) {
  std::uint64_t paths = m.sharing_.path.size(), points = m.sharing_.point.size();
  const std::uint64_t own_paths = paths, own_points = points;
  a.plain(points), a.plain(paths);
  if (points != own_points || paths != own_paths) throw dem::InputError("checkpoint.h5: of another problem");
  a.column(m.sharing_.point), a.plain(m.sharing_.next_slot);
  archive_map(a, m.sharing_.leader, [&](auto& leader) { a.plain(leader); });
  for (auto& p : m.sharing_.path) a.column(p);
  archive_map(a, m.slots_, [&](auto& s) {
    auto& memory = s.memory;
    a.plain(memory.heard);
    a.plain(memory.pending);
    a.plain(memory.stress);
    a.plain(memory.tangent);
    a.plain(memory.trust), a.plain(s.facts);
  });
  a.column(m.stress_);
  a.column(m.kept_tangent_);
  a.plain(m.sharp_);
  a.plain(m.report_);
  a.plain(m.seconds_);
}

void RveMaterial::save(const std::function<void(const std::string&)>& take) const {
  dem::Saver a;
  archive(a, *this);
  take(a.take());
  for (const auto& [slot, s] : slots_) take(farm_.fetch(slot));
}

void RveMaterial::load(const std::vector<std::string>& parts) {
  std::vector<std::uint64_t> old;
  for (const auto& [slot, s] : slots_) old.push_back(slot);
  dem::Loader a(parts.at(0));
  const std::size_t stresses = stress_.size();
  archive(a, *this);
  if (!a.at_end() || parts.size() != slots_.size() + 1) throw dem::InputError("checkpoint.h5: of another problem");
  check_sharing(sharing_, sharing_.leader, start_volume_.size());
  bool good = stress_.size() == stresses && (kept_tangent_.empty() || kept_tangent_.size() == points()) && sharp_ >= 0;
  for (const auto& [slot, s] : slots_) {
    const Memory& m = s.memory;
    good = good && sharing_.leader.contains(slot) && m.pending.allFinite() && m.pending.determinant() > 0 &&
           m.stress.allFinite() && m.tangent.allFinite() && std::isfinite(m.trust);
  }
  for (const auto& [slot, leader] : sharing_.leader) good = good && slots_.contains(slot);
  for (const Mat3& stress : stress_) good = good && stress.allFinite();
  for (const Mat6& tangent : kept_tangent_) good = good && tangent.allFinite();
  if (!good) throw dem::InputError("checkpoint.h5: checkpoint is damaged: what is known of the cells");
  for (const std::uint64_t slot : old) farm_.drop(slot);
  std::size_t part = 1;
  for (const auto& [slot, s] : slots_) farm_.put_bytes(slot, parts[part++], static_cast<double>(s.facts.grains));
}

}  // namespace grus::coupling
