// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/bursts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dem/rve/bursts.hpp"

namespace grus::app {

namespace {

std::span<const dem::BrokenBond> broken(const dem::State& state, double until) {
  const std::vector<dem::BrokenBond>& all = state.bonds.broken;  // in order of time
  const auto later = std::upper_bound(all.begin(), all.end(), until,
                                      [](double time, const dem::BrokenBond& b) { return time < b.time; });
  return {all.begin(), later};
}

std::vector<dem::Burst> bursts(const RveScene& scene, const dem::State& state, double until) {
  return dem::bursts_of(broken(state, until), scene.output.bursts);
}

}  // namespace

std::string bursts_text(const RveScene& scene, const dem::State& state, double until) {
  std::string text = "time_s,bonds,energy_J,area_m2,x_m,y_m,z_m\n";
  for (const dem::Burst& b : bursts(scene, state, until))
    text += fmt::format("{:.10g},{},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g}\n", b.time, b.bonds, b.energy, b.area,
                        b.middle.x(), b.middle.y(), b.middle.z());
  return text;
}

std::string broken_bonds_text(const dem::State& state, double until) {
  std::string text =
      "time_s,grain_a,grain_b,x_m,y_m,z_m,normal_x,normal_y,normal_z,area_m2,energy_J,shear_share,mode\n";
  for (const dem::BrokenBond& b : broken(state, until))
    text += fmt::format("{:.10g},{},{},{:.10g},{:.10g},{:.10g},{:.6g},{:.6g},{:.6g},{:.10g},{:.10g},{:.6g},{}\n",
                        b.time, b.a, b.b, b.at.x(), b.at.y(), b.at.z(), b.normal.x(), b.normal.y(), b.normal.z(),
                        b.area, b.energy, b.sliding, b.sliding < 0.5 ? "tension" : "shear");
  return text;
}

nlohmann::json bursts_json(const RveScene& scene, const dem::State& state, double until) {
  const auto all = bursts(scene, state, until);
  const dem::PowerLaw law = dem::fit_power_law(all);
  std::size_t largest = 0;
  for (const dem::Burst& b : all) largest = std::max(largest, b.bonds);
  const auto number = [](double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(nullptr); };
  nlohmann::json told{{"window_s", scene.output.bursts},
                      {"count", all.size()},
                      {"largest", largest},
                      {"exponent", number(law.exponent)},
                      {"exponent_error", number(law.error)}};
  const auto place = [](const dem::Burst& b) {
    return nlohmann::json{
        {"time_s", b.time}, {"bonds", b.bonds}, {"x_m", b.middle.x()}, {"y_m", b.middle.y()}, {"z_m", b.middle.z()}};
  };
  if (!all.empty()) told["first"] = place(all.front()), told["last"] = place(all.back());
  return told;
}

}  // namespace grus::app
