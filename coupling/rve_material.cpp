// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/rve_material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "coupling/alike.hpp"
#include "coupling/prediction.hpp"
#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/rve/steady.hpp"
#include "dem/rve/tangent.hpp"

namespace grus::coupling {

using dem::Mat3;
using dem::Mat6;

RveMaterial::RveMaterial(RveFarm& farm, const std::vector<dem::State>& states, const std::vector<std::size_t>& start,
                         const RveOptions& options)
    : farm_(farm), options_(options), point_(start.size()), responses_(start.size()) {
  std::vector<std::uint64_t> first(states.size(), UINT64_MAX);
  for (std::size_t i = 0; i < start.size(); ++i) {
    point_[i].variant = start[i];
    std::uint64_t& shared = first[start[i]];
    if (shared == UINT64_MAX || !options_.exact_sharing) {
      shared = next_slot_++;
      farm_.put(shared, states[start[i]], 1);
      slots_[shared].leader = i;
    }
    point_[i].slot = shared;
  }
  for (const auto& s : states) start_volume_.push_back(s.boundary.cell.volume());
  if (options_.share > 0)
    for (const auto& s : states) prepared_.push_back(HostedRve{.state = s}.bytes());
  path_.resize(options_.share > 0 ? start.size() : 0);
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

double RveMaterial::total(double Facts::*energy, std::span<const double> volumes) const {
  double sum = 0;
  for (std::size_t i = 0; i < volumes.size(); ++i) sum += facts(i).*energy * volumes[i] / start_volume(i);
  return sum;
}

dem::State RveMaterial::committed(std::size_t point) const {
  HostedRve rve = HostedRve::from(farm_.fetch(point_[point].slot));
  return dem::in_space(std::move(rve.state), rve.steady);
}

void RveMaterial::refresh() {
  std::vector<std::uint64_t> all;
  for (const auto& [slot, s] : slots_) all.push_back(slot);
  const std::vector<Facts> facts = farm_.facts(all);
  for (std::size_t k = 0; k < all.size(); ++k) slots_[all[k]].facts = facts[k];
}

double RveMaterial::noise() {
  double miss = 0, all = 0;
  for (std::size_t i = 0; i < responses_.size(); ++i) {
    all += responses_[i].stress.squaredNorm();
    if (!has_previous_) continue;
    const dem::Vec6 strain = strain_between(previous_deformation_[i], deformation_[i]);
    const Mat3 elastic = dem::from_voigt(previous_[i].tangent * strain);
    const double off = (responses_[i].stress - previous_[i].stress - elastic).norm();
    const bool broke_otherwise = responses_[i].breakages != previous_[i].breakages;
    // Yielding makes the stress change anything from nothing to the elastic change; what misses by more is no function
    // of strain.
    miss += std::pow(broke_otherwise ? off : std::max(0.0, off - elastic.norm()), 2);
  }
  // One pair of iterations is a small sample: what earlier pairs of the increment showed fades slowly.
  measured_noise_ = has_previous_ ? std::max(all > 0 ? std::sqrt(miss / all) : 0, 0.7 * measured_noise_) : 0;
  const dem::QuasiStatic& q = options_.response.quasi_static;
  return std::max({q.unbalanced_force, q.stress_change, std::min(measured_noise_, max_noise)});
}

bool RveMaterial::sharpen() {
  constexpr int lasting = 5;  // increments; a stall comes seldom alone
  if (options_.response.tangent != TangentKind::automatic || sharp_ > 0) return false;
  sharp_ = lasting;
  for (auto& [slot, s] : slots_) s.trial.reset();
  return true;
}

bool RveMaterial::respond(const fem::Points& points) {
  const auto begin = std::chrono::steady_clock::now();
  has_previous_ = !deformation_.empty();
  std::swap(previous_, responses_), std::swap(previous_deformation_, deformation_);
  const std::size_t n = point_.size();
  responses_.resize(n), deformation_.resize(n), job_.assign(n, SIZE_MAX);
  Alike alike;
  for (std::size_t i = 0; i < n; ++i) {
    deformation_[i] = snapped(points.deformation.subspan(9 * i, 9));
    if (options_.pace == Pace::relaxed || (options_.pace == Pace::steady && !parted()))
      deformation_[i] = alike(deformation_[i]);
  }
  reason_.clear();
  bool good = true;
  find_jobs();
  if (reason_.empty()) answer(points.duration, !points.tangent.empty());
  for (const Job& job : jobs_)
    if (!job.response.stable && reason_.empty())
      reason_ = fmt::format("RVE of point {}: {}", job.leader, job.response.failure);
  good = reason_.empty();
  if (good) {
    for (std::size_t i = 0; i < n; ++i) responses_[i] = corrected(i, jobs_[job_[i]]);
    choose_tangents();
    for (std::size_t i = 0; i < n; ++i) {
      const Answer& r = responses_[i];
      const dem::Vec6 stress = dem::to_voigt(r.stress);
      for (int k = 0; k < 6; ++k) points.stress[6 * i + static_cast<std::size_t>(k)] = stress[k];
      if (points.tangent.empty()) continue;
      for (int a = 0; a < 6; ++a)
        for (int b = 0; b < 6; ++b) points.tangent[36 * i + static_cast<std::size_t>(6 * a + b)] = r.tangent(a, b);
    }
  }
  if (!good) deformation_.clear();  // nothing to compare the next response with
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return good;
}

/// True where the tangent foretells so small a change of stress that no DEM is needed.
bool RveMaterial::foretold(const Job& job) const {
  const Slot& s = slots_.at(job.slot);
  if (!s.heard && !s.trial) return false;
  const Told last = told(job);
  Mat3 r, u;
  dem::polar(last.beyond, r, u);
  const double change = dem::from_voigt(last.tangent * strain_between(Mat3::Identity(), u)).norm();
  const double scale = std::max(last.stress.norm(), std::sqrt(3.0) * options_.response.quasi_static.pressure_floor);
  return change <= s.trust * options_.error * scale;
}

RveMaterial::Told RveMaterial::told(const Job& job) const {
  const Slot& s = slots_.at(job.slot);
  if (!s.trial) return {s.stress, s.tangent, job.increment * s.pending};
  return {s.trial->response.stress, s.trial->response.tangent, job.increment * s.trial->increment.inverse()};
}

/// RVEs that must advance now and were put off: first to where the macro solver believes them to be, which measures the
/// error.
bool RveMaterial::catch_up() {
  std::vector<Task> tasks;
  std::vector<std::uint64_t> slots;
  for (const Job& job : jobs_) {
    Slot& s = slots_.at(job.slot);
    if (!s.heard || s.trial || s.pending == Mat3::Identity() || foretold(job)) continue;
    tasks.push_back({job.slot, {s.pending}, 0, Pace::relaxed, true, sharp()});
    slots.push_back(job.slot);
  }
  if (tasks.empty()) return true;
  const std::vector<Outcome> done = farm_.advance(tasks);
  for (std::size_t k = 0; k < done.size(); ++k) {
    const dem::Response& r = done[k].response;
    report_.dem_steps += r.steps, ++(done[k].elastic ? report_.elastic : report_.advanced);
    if (done[k].elastic_error >= 0) report_.linear.add(done[k].elastic_error);
    if (!r.stable)
      return reason_ = fmt::format("RVE of point {}, which was put off, does not get to its place: {}",
                                   slots_.at(slots[k]).leader, r.failure),
             false;
  }
  const std::vector<Facts> facts = farm_.commit(slots);
  for (std::size_t k = 0; k < done.size(); ++k) {
    const dem::Response& r = done[k].response;
    Slot& s = slots_.at(slots[k]);
    const double scale = std::max(r.stress.norm(), std::sqrt(3.0) * options_.response.quasi_static.pressure_floor);
    const double error = (predicted(s.stress, s.tangent, s.pending) - r.stress).norm() / scale;
    report_.deferral.add(error);
    s.trust = std::clamp(s.trust * 0.9 * options_.error / std::max(error, 1e-12), 0.05, 1.0);
    report_.least_trust = std::min(report_.least_trust, s.trust);
    s.stress = r.stress, s.tangent = r.tangent, s.pending.setIdentity(), s.facts = facts[k];
  }
  return true;
}

/// Deferral or DEM for every job.
void RveMaterial::answer(double duration, bool tangent) {
  if (options_.error > 0 && !catch_up()) return;
  std::vector<Task> tasks;
  std::vector<std::size_t> real;
  for (std::size_t k = 0; k < jobs_.size(); ++k) {
    Job& job = jobs_[k];
    Slot& s = slots_.at(job.slot);
    // What has done DEM in this increment answers from there, not from its start.
    if (options_.error > 0 && foretold(job)) {
      const Told last = told(job);
      job.deferred = true;
      if (s.trial) job.response = s.trial->response;
      job.response.stress = predicted(last.stress, last.tangent, last.beyond);
      job.response.tangent = last.tangent, job.response.stable = true;
      continue;
    }
    s.trial.reset();
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
    if (options_.error > 0 && job.response.stable) slots_.at(job.slot).trial = {job.increment, job.response};
  }
  report_.asked += point_.size(), report_.deferred += jobs_.size() - real.size();
}

/// What a point hears of its job: for one that rides on another's path, to first order in the difference.
RveMaterial::Answer RveMaterial::corrected(std::size_t i, const Job& job) {
  const Point& leader = point_[job.leader];
  const dem::Response& r = job.response;
  if (job.leader == i || (deformation_[i] == job.increment && point_[i].total == leader.total))
    return {r.stress, r.tangent, r.breakages};
  const Mat3 difference = deformation_[i] * point_[i].total * (job.increment * leader.total).inverse();
  const Mat3 stress = predicted(r.stress, r.tangent, difference);
  ++report_.similar;
  report_.correction = std::max(
      report_.correction, (stress - r.stress).norm() /
                              std::max(stress.norm(), std::sqrt(3.0) * options_.response.quasi_static.pressure_floor));
  return {stress, r.tangent, r.breakages};
}

void RveMaterial::choose_tangents() {
  const TangentKind kind = options_.response.tangent;
  if (kind != TangentKind::elastic && kind != TangentKind::quasi_newton) return;
  const bool first = kept_tangent_.empty();
  kept_tangent_.resize(responses_.size());
  for (std::size_t i = 0; i < responses_.size(); ++i) {
    Answer& r = responses_[i];
    if (first)
      kept_tangent_[i] = r.tangent;
    else if (kind == TangentKind::quasi_newton && has_previous_)
      dem::broyden_update(strain_between(previous_deformation_[i], deformation_[i]),
                          dem::to_voigt(r.stress - previous_[i].stress), kept_tangent_[i]);
    r.tangent = kept_tangent_[i];
  }
}

void RveMaterial::commit() {
  report_.worst_unbalanced = report_.worst_stress_change = 0;
  std::vector<std::uint64_t> advanced;
  std::set<std::uint64_t> in_use;
  for (const Job& job : jobs_) {
    Slot& s = slots_.at(job.slot);
    in_use.insert(job.slot);
    s.leader = job.leader;
    if (job.deferred) s.pending = told(job).beyond;
    if (job.deferred && !s.trial) continue;
    const dem::Response& done = s.trial ? s.trial->response : job.response;
    advanced.push_back(job.slot);
    s.heard = true, s.stress = done.stress, s.tangent = done.tangent;
    if (!job.deferred) s.pending.setIdentity();
    report_.worst_unbalanced = std::max(report_.worst_unbalanced, done.unbalanced_force);
    report_.worst_stress_change = std::max(report_.worst_stress_change, done.stress_change);
  }
  if (options_.pace != Pace::relaxed) {
    for (const Job& job : jobs_) {
      Facts& facts = slots_.at(job.slot).facts;
      facts.work = job.response.work, facts.haste = job.response.haste;
    }
  } else {
    const std::vector<Facts> facts = farm_.commit(advanced);
    for (std::size_t k = 0; k < advanced.size(); ++k) slots_.at(advanced[k]).facts = facts[k];
  }
  std::vector<std::uint8_t> moved(point_.size());
  for (std::size_t i = 0; i < point_.size(); ++i) {
    Point& p = point_[i];
    moved[i] = p.slot != jobs_[job_[i]].slot;
    p.slot = jobs_[job_[i]].slot;
    p.total = deformation_[i] * p.total;
    p.stress = responses_[i].stress;
    if (options_.share > 0) path_[i].push_back(deformation_[i]);
  }
  if (options_.share > 0)
    for (std::size_t i = 0; i < point_.size(); ++i) {
      Point& p = point_[i];
      const std::size_t leader = slots_.at(p.slot).leader;
      p.distance =
          moved[i] ? distance(i, leader, INFINITY) : std::max(p.distance, (p.total - point_[leader].total).norm());
    }
  for (const auto& [slot, copies] : parted_)
    for (const auto copy : copies)
      if (!in_use.contains(copy)) farm_.drop(copy), slots_.erase(copy);
  for (auto& [slot, s] : slots_) s.trial.reset();
  parted_.clear(), jobs_.clear();
  sharp_ = std::max(0, sharp_ - 1);
  deformation_.clear();  // the next response starts another increment
  report_.distinct = slots_.size();
  if (options_.pace == Pace::relaxed) farm_.rebalance();
}

std::uint64_t RveMaterial::breakages() const {
  std::uint64_t sum = 0;
  for (const Point& p : point_) sum += slots_.at(p.slot).facts.breakages;
  return sum;
}

namespace {

template <class A, class T>
void archive_slots(A& a, T& slots) {
  std::uint64_t n = slots.size();
  a.plain(n);
  auto one = [&](auto& s) {
    a.plain(s.leader), a.plain(s.heard), a.plain(s.pending), a.plain(s.stress), a.plain(s.tangent), a.plain(s.trust),
        a.plain(s.facts);
  };
  if constexpr (std::is_const_v<T>) {
    for (const auto& [slot, s] : slots) a.plain(slot), one(s);
  } else {
    slots.clear();
    for (std::uint64_t k = 0, slot; k < n; ++k) a.plain(slot), one(slots[slot]);
  }
}

}  // namespace

void RveMaterial::save(const std::function<void(const std::string&)>& take) const {
  dem::Saver a;
  a.column(point_), archive_slots(a, slots_), a.plain(static_cast<std::uint64_t>(path_.size()));
  for (const auto& p : path_) a.column(p);
  a.column(kept_tangent_), a.plain(sharp_), a.plain(report_), a.plain(next_slot_), a.plain(seconds_);
  take(a.take());
  for (const auto& [slot, s] : slots_) take(farm_.fetch(slot));
}

void RveMaterial::load(const std::vector<std::string>& parts) {
  for (const auto& [slot, s] : slots_) farm_.drop(slot);
  const std::size_t n = point_.size();
  std::uint64_t paths;
  dem::Loader a(parts.at(0));
  a.column(point_), archive_slots(a, slots_), a.plain(paths);
  if (point_.size() != n || paths != path_.size() || parts.size() != slots_.size() + 1)
    throw dem::InputError("checkpoint.h5: of another problem");
  for (auto& p : path_) a.column(p);
  a.column(kept_tangent_), a.plain(sharp_), a.plain(report_), a.plain(next_slot_), a.plain(seconds_);
  std::size_t part = 1;
  for (const auto& [slot, s] : slots_) farm_.put_bytes(slot, parts[part++], static_cast<double>(s.facts.grains));
}

}  // namespace grus::coupling
