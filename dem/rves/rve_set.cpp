// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rves/rve_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "dem/base/checksum.hpp"
#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/rves/alike.hpp"

namespace grus::dem {

RveSet::RveSet(std::shared_ptr<const Model> model, const std::vector<State>& prepared,
               std::span<const std::size_t> start, const ResponseOptions& options, int threads, std::uint64_t kin)
    : host_(std::move(model), options, threads),
      sharp_(options.tangent == TangentKind::network),
      kin_(kin),
      sharing_(begin_sharing(start, true, 0)) {
  for (const State& s : prepared)
    if (!s.boundary.cell.periodic()) throw InputError("an RVE is a periodic cell: boundary.kind = \"periodic\"");
  for (const auto& [slot, leader] : sharing_.leader) host_.put(slot, {.state = prepared.at(start[leader])});
}

void RveSet::advance(std::span<const double> deformation, std::span<double> stress, std::span<double> tangent,
                     const Watch& watch) {
  const std::size_t n = size();
  if (deformation.size() != 9 * n || stress.size() != 6 * n || (!tangent.empty() && tangent.size() != 36 * n))
    throw InputError(fmt::format("{} points need 9, 6 and 36 (or no) numbers each; given {}, {} and {} in all", n,
                                 deformation.size(), stress.size(), tangent.size()));
  response_.clear();
  std::vector<Mat3> increment(n);
  Alike alike;
  for (std::size_t i = 0; i < n; ++i) {
    const Mat3 f = snapped(deformation.subspan(9 * i, 9));
    if (!f.allFinite()) throw InputError(fmt::format("deformation of point {}: not a finite number", i));
    if (f.determinant() <= 0)
      throw InputError(
          fmt::format("deformation of point {}: det F = {:.4g}; an increment has det F > 0, and is "
                      "F_new F_old^-1, not a strain",
                      i, f.determinant()));
    increment[i] = alike(f);
  }
  increment_ = std::move(increment);
  plan_ = plan(sharing_, increment_);
  for (const auto& copy : plan_.copy) host_.copy(copy.from, copy.to);
  std::vector<Task> tasks;
  for (const auto& job : plan_.job)
    tasks.push_back({job.slot, {job.increment}, 0, Pace::relaxed, !tangent.empty(), sharp_});
  std::vector<Response> responses;
  for (Outcome& outcome : host_.advance(tasks, watch)) responses.push_back(std::move(outcome.response));
  for (std::size_t k = 0; k < responses.size(); ++k)
    if (!responses[k].stable)
      throw Unstable(fmt::format("RVE of point {}: {}", plan_.job[k].leader, responses[k].failure));
  for (std::size_t i = 0; i < n; ++i) {
    const Response& r = responses[plan_.of[i]];
    const Vec6 voigt = to_voigt(r.stress);
    std::copy_n(voigt.data(), 6, stress.data() + 6 * i);
    if (!tangent.empty()) Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(tangent.data() + 36 * i) = r.tangent;
  }
  response_ = std::move(responses);
}

const Response& RveSet::response(std::size_t point) const {
  if (response_.empty()) throw std::logic_error("no advance since the last commit");
  return response_[plan_.of.at(point)];
}

void RveSet::commit() {
  if (response_.empty()) throw std::logic_error("nothing to commit: advance comes first");
  std::vector<std::uint64_t> slots;
  for (const auto& job : plan_.job) slots.push_back(job.slot);
  host_.commit(slots);
  for (const std::uint64_t slot : dem::commit(sharing_, plan_, increment_)) host_.drop(slot);
  response_.clear();
}

/// Copies that an advance without commit has made.
void RveSet::forget() {
  for (const auto& [slot, copies] : sharing_.copies)
    for (const std::uint64_t copy : copies) host_.drop(copy), sharing_.leader.erase(copy);
  sharing_.copies.clear();
  response_.clear();
}

std::string RveSet::sealed(const std::string& bytes) const {
  Saver a;
  a.plain(kin_);
  a.plain(checksum(bytes));
  return a.take() + bytes;
}

std::string RveSet::opened(const std::string& bytes) const {
  std::uint64_t kin = 0, seal = 0;
  Loader a(bytes);
  a.plain(kin), a.plain(seal);
  if (kin != kin_) throw InputError("state of another scene, other settings or another version");
  std::string inner = bytes.substr(sizeof kin + sizeof seal);
  if (checksum(inner) != seal) throw InputError("state is damaged: its checksum does not match");
  return inner;
}

std::string RveSet::bytes(std::size_t point) const {
  return sealed(host_.hosted(sharing_.point.at(point).slot).bytes());
}

void RveSet::restore(std::size_t point, const std::string& bytes) {
  Sharing::Point& mine = sharing_.point.at(point);
  HostedRve rve = HostedRve::from(opened(bytes));
  host_.check(rve);
  forget();
  const std::uint64_t old = mine.slot;
  const std::size_t n = size();
  std::size_t other = point;  // that goes on with the old RVE; the next one, as a rule
  for (std::size_t k = 1; k < n && other == point; ++k)
    if (sharing_.point[(point + k) % n].slot == old) other = (point + k) % n;
  if (other != point) {
    if (sharing_.leader.at(old) == point) sharing_.leader[old] = other;
    mine.slot = sharing_.next_slot++;
  }
  sharing_.leader[mine.slot] = point;
  host_.put(mine.slot, std::move(rve));
}

void RveSet::save(const std::function<void(const std::string&)>& take) const {
  Saver a;
  a.column(sharing_.point), a.plain(sharing_.next_slot);
  std::vector<std::pair<std::uint64_t, std::uint64_t>> leaders;
  for (const auto& [slot, leader] : sharing_.leader)
    if (sharing_.point[leader].slot == slot) leaders.emplace_back(slot, leader);
  a.column(leaders);
  take(sealed(a.take()));
  for (const auto& [slot, leader] : leaders) take(bytes(leader));
}

void RveSet::load(const std::vector<std::string>& parts) {
  if (parts.empty()) throw InputError("no states");
  const std::string inner = opened(parts[0]);
  Loader a(inner);
  Sharing sharing;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> leaders;
  a.column(sharing.point), a.plain(sharing.next_slot), a.column(leaders);
  if (sharing.point.size() != size())
    throw InputError(fmt::format("states of {} points, where there are {}", sharing.point.size(), size()));
  if (parts.size() != leaders.size() + 1) throw InputError("states are cut short");
  std::vector<HostedRve> rves;
  for (std::size_t k = 0; k < leaders.size(); ++k)
    rves.push_back(HostedRve::from(opened(parts[k + 1]))), host_.check(rves.back());
  std::map<std::uint64_t, std::size_t> leads;
  for (const auto& [slot, leader] : leaders) leads[slot] = leader;
  check_sharing(sharing, leads, SIZE_MAX);
  forget();
  for (const auto& [slot, leader] : sharing_.leader) host_.drop(slot);
  for (std::size_t k = 0; k < leaders.size(); ++k) {
    sharing.leader[leaders[k].first] = leaders[k].second;
    host_.put(leaders[k].first, std::move(rves[k]));
  }
  sharing_ = std::move(sharing);
}

}  // namespace grus::dem
