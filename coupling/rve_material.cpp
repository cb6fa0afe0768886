// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/rve_material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "dem/base/error.hpp"
#include "dem/rve/tangent.hpp"

namespace grus::coupling {
namespace {

/// Increments are taken to 2^-34 (6e-11 of strain, 0.1 Pa): the macro solver's round-off, which depends on the number of
/// ranks, neither tells two points apart nor reaches the grains, and all see the same value whether they share or not.
dem::Mat3 snapped(std::span<const double> f) {
  dem::Mat3 m;
  for (int k = 0; k < 9; ++k) m(k / 3, k % 3) = std::ldexp(std::nearbyint(std::ldexp(f[static_cast<std::size_t>(k)], 34)), -34);
  return m;
}

dem::Vec6 strain_between(const dem::Mat3& from, const dem::Mat3& to) {
  dem::Vec6 strain = dem::to_voigt(to - from);
  strain.tail<3>() *= 2;
  return strain;
}

}  // namespace

RveMaterial::RveMaterial(std::shared_ptr<const dem::Model> model, const dem::QuasiStatic& quasi_static, std::vector<dem::State> states,
                         std::vector<std::size_t> start, int threads, const RveOptions& options)
    : model_(std::move(model)), quasi_static_(quasi_static), options_(options), responses_(start.size()), team_(threads) {
  if (options_.share) {
    slot_ = std::move(start);
    for (auto& state : states) pool_.push_back(std::make_unique<dem::Rve>(model_, quasi_static, std::move(state)));
  } else {
    for (const std::size_t s : start) {
      slot_.push_back(pool_.size());
      pool_.push_back(std::make_unique<dem::Rve>(model_, quasi_static, states[s]));
    }
  }
  report_.distinct = pool_.size();
}

fem::Material RveMaterial::material(MPI_Comm comm) {
  fem::Material m;
  m.respond = [this](const fem::Points& p) { return respond(p); };
  m.commit = [this] { commit(); };
  m.noise = [this, comm] { return noise(comm); };
  m.reason = [this] { return reason_; };
  return m;
}

double RveMaterial::noise(MPI_Comm comm) const {
  double sums[2] = {0, 0}, all[2];
  for (std::size_t i = 0; i < responses_.size(); ++i) {
    sums[1] += responses_[i].stress.squaredNorm();
    if (!has_previous_ || responses_[i].breakages == previous_[i].breakages) continue;
    const dem::Vec6 strain = strain_between(previous_deformation_[i], deformation_[i]);
    sums[0] += (responses_[i].stress - previous_[i].stress - dem::from_voigt(previous_[i].tangent * strain)).squaredNorm();
  }
  MPI_Allreduce(sums, all, 2, MPI_DOUBLE, MPI_SUM, comm);
  const double measured = all[1] > 0 ? std::sqrt(all[0] / all[1]) : 0;
  return std::max({quasi_static_.unbalanced_force, quasi_static_.stress_change, std::min(measured, max_noise)});
}

bool RveMaterial::respond(const fem::Points& points) {
  const auto begin = std::chrono::steady_clock::now();
  has_previous_ = !deformation_.empty();
  std::swap(previous_, responses_), std::swap(previous_deformation_, deformation_);
  const std::size_t n = slot_.size();
  responses_.resize(n), deformation_.resize(n), job_.resize(n);

  // Points of one RVE with one increment are one job; others of the same RVE part from it on a copy.
  jobs_.clear();
  std::map<std::pair<std::size_t, std::array<double, 9>>, std::size_t> known;
  std::vector<std::uint8_t> taken(pool_.size(), 0);
  for (std::size_t i = 0; i < n; ++i) {
    deformation_[i] = snapped(points.deformation.subspan(9 * i, 9));
    std::array<double, 9> key;
    std::copy_n(deformation_[i].data(), 9, key.begin());
    const auto [at, fresh] = known.try_emplace({slot_[i], key}, jobs_.size());
    job_[i] = at->second;
    if (!fresh) continue;
    Job job{slot_[i], {deformation_[i]}, nullptr, {}};
    if (taken[slot_[i]]) job.copy = std::make_unique<dem::Rve>(model_, quasi_static_, pool_[slot_[i]]->committed());
    taken[slot_[i]] = 1;
    jobs_.push_back(std::move(job));
  }
  team_.each(jobs_.size(), [&](std::size_t k) {
    Job& job = jobs_[k];
    dem::Rve& rve = job.copy ? *job.copy : *pool_[job.slot];
    try {
      job.response = rve.advance(job.increment);
      if (options_.tangent == TangentKind::perturbation && job.response.stable) {
        dem::Team alone(1);
        job.response.tangent = dem::perturbation_tangent(*model_, quasi_static_, rve.trial(), options_.perturbation, options_.central, job.response.steps, alone);
      }
    } catch (const std::exception& e) {  // must not leave a thread
      job.response = {};
      job.response.failure = e.what();
    }
  });
  for (std::size_t i = 0; i < n; ++i) responses_[i] = jobs_[job_[i]].response;
  choose_tangents();

  bool good = true;
  for (const auto& job : jobs_) report_.dem_steps += job.response.steps;
  report_.advanced += jobs_.size(), report_.asked += n;
  for (std::size_t i = 0; i < n; ++i) {
    const dem::Response& r = responses_[i];
    if (!r.stable && good) {
      good = false;
      reason_ = fmt::format("RVE of point {}: {}", i, r.failure);
    }
    const dem::Vec6 stress = dem::to_voigt(r.stress);
    for (int k = 0; k < 6; ++k) points.stress[6 * i + static_cast<std::size_t>(k)] = stress[k];
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) points.tangent[36 * i + static_cast<std::size_t>(6 * a + b)] = r.tangent(a, b);
  }
  report_.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return good;
}

void RveMaterial::choose_tangents() {
  if (options_.tangent != TangentKind::elastic && options_.tangent != TangentKind::quasi_newton) return;
  const bool first = kept_tangent_.empty();
  kept_tangent_.resize(responses_.size());
  for (std::size_t i = 0; i < responses_.size(); ++i) {
    dem::Response& r = responses_[i];
    if (first) kept_tangent_[i] = r.tangent;
    else if (options_.tangent == TangentKind::quasi_newton && has_previous_ && r.stable)
      dem::broyden_update(strain_between(previous_deformation_[i], deformation_[i]), dem::to_voigt(r.stress - previous_[i].stress), kept_tangent_[i]);
    r.tangent = kept_tangent_[i];
  }
}

void RveMaterial::commit() {
  report_.worst_unbalanced = report_.worst_stress_change = 0;
  std::vector<std::size_t> place(jobs_.size());
  for (std::size_t k = 0; k < jobs_.size(); ++k) {
    Job& job = jobs_[k];
    place[k] = job.copy ? pool_.size() : job.slot;
    if (job.copy) pool_.push_back(std::move(job.copy));
    pool_[place[k]]->commit();
    report_.worst_unbalanced = std::max(report_.worst_unbalanced, job.response.unbalanced_force);
    report_.worst_stress_change = std::max(report_.worst_stress_change, job.response.stress_change);
  }
  for (std::size_t i = 0; i < slot_.size(); ++i) slot_[i] = place[job_[i]];
  report_.distinct = pool_.size();
  jobs_.clear();
  deformation_.clear();  // the next response starts another increment
}

std::size_t RveMaterial::breakages() const {
  std::size_t sum = 0;
  for (const std::size_t s : slot_) sum += pool_[s]->committed().ledger.breakages;
  return sum;
}

}  // namespace grus::coupling
