// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/bursts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dem/rve/bursts.hpp"

namespace grus::app {

std::string bursts_text(const RveScene& scene, const dem::State& state) {
  std::string text = "time_s,bonds,energy_J,area_m2,x_m,y_m,z_m\n";
  for (const dem::Burst& b : dem::bursts_of(state.bonds.broken, scene.output.bursts))
    text += fmt::format("{:.10g},{},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g}\n", b.time, b.bonds, b.energy, b.area,
                        b.middle.x(), b.middle.y(), b.middle.z());
  return text;
}

nlohmann::json bursts_json(const RveScene& scene, const dem::State& state) {
  const auto bursts = dem::bursts_of(state.bonds.broken, scene.output.bursts);
  const dem::PowerLaw law = dem::fit_power_law(bursts);
  std::size_t largest = 0;
  for (const dem::Burst& b : bursts) largest = std::max(largest, b.bonds);
  const auto number = [](double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(nullptr); };
  nlohmann::json told{{"window_s", scene.output.bursts},
                      {"count", bursts.size()},
                      {"largest", largest},
                      {"exponent", number(law.exponent)},
                      {"exponent_error", number(law.error)}};
  const auto place = [](const dem::Burst& b) {
    return nlohmann::json{
        {"time_s", b.time}, {"bonds", b.bonds}, {"x_m", b.middle.x()}, {"y_m", b.middle.y()}, {"z_m", b.middle.z()}};
  };
  if (!bursts.empty()) told["first"] = place(bursts.front()), told["last"] = place(bursts.back());
  return told;
}

}  // namespace grus::app
