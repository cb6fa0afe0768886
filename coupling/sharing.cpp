// SPDX-License-Identifier: LGPL-3.0-or-later
// Which points go together in a response: RveMaterial's jobs.
#include <fmt/format.h>

#include <algorithm>

#include "coupling/rve_material.hpp"

namespace grus::coupling {

using dem::Mat3;

std::size_t RveMaterial::add_job(std::uint64_t slot, std::size_t leader) {
  jobs_.push_back({slot, leader, deformation_[leader], false, {}});
  jobs_of_[point_[leader].slot].push_back(jobs_.size() - 1);
  return jobs_.size() - 1;
}

/// A new slot that starts as a copy of another one; those that earlier responses of the increment made are used again.
std::uint64_t RveMaterial::part(std::uint64_t slot, std::size_t leader) {
  auto& copies = parted_[slot];
  const std::size_t number = jobs_of_[slot].size() - 1;  // the first increment is the slot's own
  if (number >= copies.size()) {
    copies.push_back(next_slot_++);
    farm_.copy(slot, copies.back());
    slots_[copies.back()] = slots_.at(slot);
    slots_[copies.back()].trial.reset();
  }
  slots_[copies[number]].leader = leader;
  return copies[number];
}

/// Who goes with whom: fills jobs_ and job_.
void RveMaterial::find_jobs() {
  jobs_.clear(), jobs_of_.clear();
  if (options_.pace != Pace::relaxed && parted()) {
    for (std::size_t i = 0; i < point_.size(); ++i)
      jobs_.push_back({point_[i].slot, i, deformation_[i], false, {}}), job_[i] = i;
    return;
  }
  const auto own = [&](std::size_t i) -> std::vector<std::size_t>& { return jobs_of_[point_[i].slot]; };
  for (const auto& [slot, s] : slots_)  // leaders first: they never leave their RVE
    if (point_[s.leader].slot == slot) job_[s.leader] = add_job(slot, s.leader);
  std::map<std::pair<std::uint64_t, std::array<double, 9>>, std::size_t> known;
  auto key = [&](std::size_t i) {
    std::array<double, 9> f;
    std::copy_n(deformation_[i].data(), 9, f.begin());
    return std::pair{point_[i].slot, f};
  };
  for (std::size_t k = 0; k < jobs_.size(); ++k) known.try_emplace(key(jobs_[k].leader), k);
  for (std::size_t i = 0; i < point_.size(); ++i) {
    if (job_[i] != SIZE_MAX) continue;
    const auto same = known.find(key(i));
    if (same != known.end() && point_[i].distance == point_[jobs_[same->second].leader].distance &&
        point_[i].total == point_[jobs_[same->second].leader].total) {
      job_[i] = same->second;
      continue;
    }
    if (options_.share > 0) {
      auto rides = [&](std::size_t k) {
        const Job& job = jobs_[k];
        if (point_[job.leader].variant != point_[i].variant) return false;
        if ((deformation_[i] * point_[i].total - job.increment * point_[job.leader].total).norm() > options_.share)
          return false;
        return (job.slot == point_[i].slot ? point_[i].distance : distance(i, job.leader, options_.share)) <=
               options_.share;
      };
      const auto first = own(i).front();
      if (rides(first)) {
        job_[i] = first;
        continue;
      }
      for (std::size_t k = 0; k < jobs_.size() && job_[i] == SIZE_MAX; ++k)
        if (rides(k)) job_[i] = k;
      if (job_[i] != SIZE_MAX) continue;
      if (point_[i].distance > 0) {  // what it has ridden on is not its own past
        if (!replay(i)) return;
        job_[i] = add_job(point_[i].slot, i);
        known.try_emplace(key(i), job_[i]);
        continue;
      }
    }
    job_[i] = add_job(part(point_[i].slot, i), i);
    known.try_emplace(key(i), job_[i]);
  }
}

/// Largest difference of two points' deformation gradients over their committed paths; more than `limit` is not told
/// exactly.
double RveMaterial::distance(std::size_t a, std::size_t b, double limit) const {
  Mat3 fa = Mat3::Identity(), fb = fa;
  double most = 0;
  for (std::size_t k = 0; k < path_[a].size() && most <= limit; ++k) {
    fa = path_[a][k] * fa, fb = path_[b][k] * fb;
    most = std::max(most, (fa - fb).norm());
  }
  return most;
}

/// The point's own path from the prepared state: its RVE from now on, whatever becomes of this increment.
bool RveMaterial::replay(std::size_t i) {
  const std::uint64_t slot = next_slot_++;
  farm_.put_bytes(slot, prepared_[point_[i].variant], farm_.cost(point_[i].slot));
  const std::vector<Outcome> done = farm_.advance({{slot, path_[i], 0, Pace::relaxed, true, sharp()}});
  const dem::Response& r = done[0].response;
  report_.dem_steps += r.steps, ++report_.replayed;
  if (!r.stable) {
    farm_.drop(slot);
    reason_ = fmt::format("the RVE of point {} does not get through the point's own path: {}", i, r.failure);
    return false;
  }
  report_.sharing.add((r.stress - point_[i].stress).norm() /
                      std::max(r.stress.norm(), std::sqrt(3.0) * options_.response.quasi_static.pressure_floor));
  Slot& s = slots_[slot];
  s.leader = i, s.heard = true, s.stress = r.stress, s.tangent = r.tangent;
  s.facts = farm_.commit({slot})[0];
  point_[i].slot = slot, point_[i].distance = 0;
  return true;
}

}  // namespace grus::coupling
