// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rves/sharing.hpp"

#include "dem/base/error.hpp"

#include <algorithm>
#include <array>
#include <set>

namespace grus::dem {

void check_sharing(const Sharing& s, const std::map<std::uint64_t, std::size_t>& leader, std::size_t variants) {
  bool good = true;
  for (const Sharing::Point& p : s.point)
    good = good && leader.contains(p.slot) && p.variant < variants && p.total.allFinite() && p.distance >= 0 &&
           p.total.determinant() > 0;
  for (const auto& [slot, point] : leader)
    good = good && slot < s.next_slot && point < s.point.size() && s.point[point].slot == slot;
  for (const auto& path : s.path)
    for (const Mat3& f : path) good = good && f.allFinite() && f.determinant() > 0;
  if (!good) throw InputError("checkpoint is damaged: points and their RVEs");
}
namespace {

/// Largest difference of two points' deformation gradients over their committed paths; more than `limit` is not told
/// exactly.
double distance(const Sharing& s, std::size_t a, std::size_t b, double limit) {
  Mat3 fa = Mat3::Identity(), fb = fa;
  double most = 0;
  for (std::size_t k = 0; k < s.path[a].size() && most <= limit; ++k) {
    fa = s.path[a][k] * fa, fb = s.path[b][k] * fb;
    most = std::max(most, (fa - fb).norm());
  }
  return most;
}

/// A plan in the making.
class Planner {
public:
  Planner(Sharing& sharing, std::span<const Mat3> increment) : s_(sharing), increment_(increment) {
    plan_.of.assign(s_.point.size(), none);
  }

  SharingPlan make() {
    for (const auto& [slot, leader] : s_.leader)  // leaders first: they never leave their RVE
      if (s_.point[leader].slot == slot) plan_.of[leader] = add_job(slot, leader);
    for (std::size_t k = 0; k < plan_.job.size(); ++k) known_.try_emplace(key(plan_.job[k].leader), k);
    for (std::size_t i = 0; i < s_.point.size(); ++i)
      if (plan_.of[i] == none && !goes_with_its_like(i) && !(s_.tolerance > 0 && rides_or_replays(i))) {
        plan_.of[i] = add_job(part(s_.point[i].slot, i), i);
        known_.try_emplace(key(i), plan_.of[i]);
      }
    return std::move(plan_);
  }

private:
  static constexpr std::size_t none = SIZE_MAX;
  using Key = std::pair<std::uint64_t, std::array<double, 9>>;

  Key key(std::size_t i) const {
    std::array<double, 9> f;
    std::copy_n(increment_[i].data(), 9, f.begin());
    return {s_.point[i].slot, f};
  }

  std::size_t add_job(std::uint64_t slot, std::size_t leader) {
    plan_.job.push_back({slot, leader, increment_[leader]});
    jobs_of_[s_.point[leader].slot].push_back(plan_.job.size() - 1);
    return plan_.job.size() - 1;
  }

  /// A new slot that starts as a copy of another one; those that earlier responses of the increment made are used
  /// again.
  std::uint64_t part(std::uint64_t slot, std::size_t leader) {
    auto& copies = s_.copies[slot];
    const std::size_t number = jobs_of_[slot].size() - 1;  // the first increment is the slot's own
    if (number >= copies.size()) {
      copies.push_back(s_.next_slot++);
      plan_.copy.push_back({slot, copies.back()});
    }
    s_.leader[copies[number]] = leader;
    return copies[number];
  }

  bool goes_with_its_like(std::size_t i) {
    const auto same = known_.find(key(i));
    if (same == known_.end()) return false;
    const Sharing::Point &mine = s_.point[i], &theirs = s_.point[plan_.job[same->second].leader];
    if (mine.distance != theirs.distance || mine.total != theirs.total) return false;
    plan_.of[i] = same->second;
    return true;
  }

  bool near(std::size_t i, std::size_t k) const {
    const SharingPlan::Job& job = plan_.job[k];
    const Sharing::Point &mine = s_.point[i], &theirs = s_.point[job.leader];
    if (theirs.variant != mine.variant) return false;
    if ((increment_[i] * mine.total - job.increment * theirs.total).norm() > s_.tolerance) return false;
    return (job.slot == mine.slot ? mine.distance : distance(s_, i, job.leader, s_.tolerance)) <= s_.tolerance;
  }

  /// Similar sharing; false: the point needs a copy of its RVE.
  bool rides_or_replays(std::size_t i) {
    Sharing::Point& p = s_.point[i];
    const std::size_t own = jobs_of_[p.slot].front();
    if (near(i, own)) {
      plan_.of[i] = own;
      return true;
    }
    for (std::size_t k = 0; k < plan_.job.size(); ++k)
      if (near(i, k)) {
        plan_.of[i] = k;
        return true;
      }
    if (p.distance == 0) return false;
    // What it has ridden on is not its own past.
    plan_.replay.push_back({i, s_.next_slot++, p.slot, p.distance});
    p.slot = plan_.replay.back().slot, p.distance = 0;
    s_.leader[p.slot] = i;
    plan_.of[i] = add_job(p.slot, i);
    known_.try_emplace(key(i), plan_.of[i]);
    return true;
  }

  Sharing& s_;
  std::span<const Mat3> increment_;
  SharingPlan plan_;
  std::map<std::uint64_t, std::vector<std::size_t>> jobs_of_;  // slot that points have -> jobs that began there
  std::map<Key, std::size_t> known_;
};

}  // namespace

Sharing begin_sharing(std::span<const std::size_t> start, bool exact, double tolerance) {
  Sharing s;
  s.tolerance = tolerance;
  s.point.resize(start.size());
  s.path.resize(tolerance > 0 ? start.size() : 0);
  std::map<std::size_t, std::uint64_t> first;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const bool known = exact && first.contains(start[i]);
    if (!known) first[start[i]] = s.next_slot++;
    s.point[i].slot = first[start[i]], s.point[i].variant = start[i];
    if (!known) s.leader[s.point[i].slot] = i;
  }
  return s;
}

SharingPlan plan(Sharing& sharing, std::span<const Mat3> increment) { return Planner(sharing, increment).make(); }

void plan_parted(const Sharing& s, std::span<const Mat3> increment, SharingPlan& plan) {
  if (!plan.apart) plan = {};
  plan.apart = true;
  plan.job.resize(s.point.size());
  while (plan.of.size() < s.point.size()) plan.of.push_back(plan.of.size());
  for (std::size_t i = 0; i < s.point.size(); ++i) plan.job[i] = {s.point[i].slot, i, increment[i]};
}

void undo(Sharing& s, const SharingPlan::Replay& replay) {
  s.point[replay.point].slot = replay.was, s.point[replay.point].distance = replay.distance;
  s.leader.erase(replay.slot);
}

void undo(Sharing& s, const SharingPlan::Copy& copy) {
  std::erase(s.copies[copy.from], copy.to);
  s.leader.erase(copy.to);
}

std::vector<std::uint64_t> commit(Sharing& s, const SharingPlan& plan, std::span<const Mat3> increment) {
  if (plan.apart) {  // nobody moves, and there are no copies
    for (std::size_t i = 0; i < s.point.size(); ++i) s.point[i].total = increment[i] * s.point[i].total;
    return {};
  }
  std::set<std::uint64_t> in_use;
  for (const SharingPlan::Job& job : plan.job) s.leader[job.slot] = job.leader, in_use.insert(job.slot);
  std::vector<std::uint8_t> moved(s.point.size());
  for (std::size_t i = 0; i < s.point.size(); ++i) {
    Sharing::Point& p = s.point[i];
    const std::uint64_t slot = plan.job[plan.of[i]].slot;
    moved[i] = p.slot != slot;
    p.slot = slot;
    p.total = increment[i] * p.total;
    if (s.tolerance > 0) s.path[i].push_back(increment[i]);
  }
  if (s.tolerance > 0)
    for (std::size_t i = 0; i < s.point.size(); ++i) {
      Sharing::Point& p = s.point[i];
      const std::size_t leader = s.leader.at(p.slot);
      p.distance =
          moved[i] ? distance(s, i, leader, INFINITY) : std::max(p.distance, (p.total - s.point[leader].total).norm());
    }
  std::vector<std::uint64_t> unused;
  for (const auto& [slot, copies] : s.copies)
    for (const std::uint64_t copy : copies)
      if (!in_use.contains(copy)) unused.push_back(copy), s.leader.erase(copy);
  s.copies.clear();
  return unused;
}

}  // namespace grus::dem
