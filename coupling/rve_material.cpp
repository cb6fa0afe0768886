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

fem::Material RveMaterial::material() {
  fem::Material m;
  m.respond = [this](const fem::Points& p) { return respond(p); };
  m.commit = [this] { commit(); };
  m.noise = std::max(options_.unbalanced_force, options_.stress_change);
  m.reason = [this] { return reason_; };
  return m;
}

bool RveMaterial::respond(const fem::Points& points) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<std::string> errors(rves_.size());
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
    report_.deepest_breakage = std::max(report_.deepest_breakage, rves_[i].committed().ledger.breakages);
  }
}

std::size_t RveMaterial::breakages() const {
  std::size_t sum = 0;
  for (const auto& rve : rves_) sum += rve.committed().ledger.breakages;
  return sum;
}

}  // namespace grus::coupling
