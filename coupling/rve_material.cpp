// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/rve_material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>


namespace grus::coupling {

RveMaterial::RveMaterial(std::shared_ptr<const dem::Model> model, const dem::QuasiStatic& options, std::vector<dem::State> states, int threads)
    : options_(options), responses_(states.size()), team_(threads) {
  rves_.reserve(states.size());
  for (auto& state : states) rves_.emplace_back(model, options, std::move(state));
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
    dem::Mat3 step;
    for (int k = 0; k < 9; ++k) step(k / 3, k % 3) = deformation_[9 * i + static_cast<std::size_t>(k)] - previous_deformation_[9 * i + static_cast<std::size_t>(k)];
    dem::Vec6 strain = dem::to_voigt(step);
    strain.tail<3>() *= 2;
    sums[0] += (responses_[i].stress - previous_[i].stress - dem::from_voigt(previous_[i].tangent * strain)).squaredNorm();
  }
  MPI_Allreduce(sums, all, 2, MPI_DOUBLE, MPI_SUM, comm);
  const double measured = all[1] > 0 ? std::sqrt(all[0] / all[1]) : 0;
  return std::max({options_.unbalanced_force, options_.stress_change, std::min(measured, max_noise)});
}

bool RveMaterial::respond(const fem::Points& points) {
  const auto start = std::chrono::steady_clock::now();
  has_previous_ = !deformation_.empty();
  std::swap(previous_, responses_), std::swap(previous_deformation_, deformation_);
  responses_.resize(rves_.size());
  deformation_.assign(points.deformation.begin(), points.deformation.end());
  team_.each(rves_.size(), [&](std::size_t i) {
    dem::Increment increment;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) increment.deformation(r, c) = points.deformation[9 * i + static_cast<std::size_t>(3 * r + c)];
    try {
      responses_[i] = rves_[i].advance(increment);
    } catch (const std::exception& e) {  // must not leave a thread
      responses_[i] = {};
      responses_[i].failure = e.what();
    }
  });
  bool good = true;
  for (std::size_t i = 0; i < rves_.size(); ++i) {
    const dem::Response& r = responses_[i];
    report_.dem_steps += r.steps;
    ++report_.advanced;
    if (!r.stable && good) {
      good = false;
      reason_ = fmt::format("RVE of point {}: {}", i, r.failure);
    }
    const dem::Vec6 stress = dem::to_voigt(r.stress);
    for (int k = 0; k < 6; ++k) points.stress[6 * i + static_cast<std::size_t>(k)] = stress[k];
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) points.tangent[36 * i + static_cast<std::size_t>(6 * a + b)] = r.tangent(a, b);
  }
  report_.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return good;
}

void RveMaterial::commit() {
  report_.worst_unbalanced = report_.worst_stress_change = 0;
  for (std::size_t i = 0; i < rves_.size(); ++i) {
    rves_[i].commit();
    report_.worst_unbalanced = std::max(report_.worst_unbalanced, responses_[i].unbalanced_force);
    report_.worst_stress_change = std::max(report_.worst_stress_change, responses_[i].stress_change);
  }
  deformation_.clear();  // the next response starts another increment
}

std::size_t RveMaterial::breakages() const {
  std::size_t sum = 0;
  for (const auto& rve : rves_) sum += rve.committed().ledger.breakages;
  return sum;
}

}  // namespace grus::coupling
