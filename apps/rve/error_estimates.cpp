// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/error_estimates.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "dem/rve/step.hpp"

namespace grus::app {

void ErrorEstimates::add(const dem::State& state, const dem::Loading& loading, const dem::Survey& m) {
  holds = holds || loading.holds;
  if (const double off = dem::stress_error(state, loading, m); off < INFINITY)
    stress.add(off), stress_sum += off, ++stress_rows;
  energy.add(std::abs(dem::told_energy_error(state, m.kinetic + m.elastic)));
  unbalanced.add(m.unbalanced_force);
  overlap.add(m.deepest.ratio);
  if (m.volume <= 0) return;
  const double wall = m.wall_stress.trace() / 3;
  largest_wall = std::max(largest_wall, std::abs(wall));
  if (wall != 0) wall_minus_cell.add(std::abs(wall - m.stress.trace() / 3) / largest_wall);
  pressure_scatter.add(m.pressure_scatter);
}

const char* ErrorEstimates::advice(bool solved, bool presses) const {
  if (holds && solved) return "a long step passes it: lower numerics.max_time_step, or strain_rate";
  if (holds)
    return "the boundary had yet to find the sample, or moves faster than it can follow the stress; lower strain_rate, "
           "go on to a larger final_strain, or take more grains";
  return presses ? "raise the max_speed of the wall, which bounds the search, or take longer"
                 : "raise the strain_rate that bounds the search, or take longer";
}

nlohmann::json ErrorEstimates::json(const dem::State& state) const {
  nlohmann::json out = {{"worst_energy_error", energy.worst}};
  auto put = [&](const char* name, const Estimate& e) { out[name] = {{"last", e.last}, {"worst", e.worst}}; };
  put("unbalanced_force", unbalanced), put("overlap_to_radius", overlap);
  if (dem::bulk_volume(state.boundary) > 0) put("pressure_standard_error", pressure_scatter);
  if (!state.boundary.walls.empty() && dem::bulk_volume(state.boundary) > 0)
    put("wall_minus_cell_pressure", wall_minus_cell);
  if (stress_rows > 0)
    out[holds ? "lateral_stress" : "sought_stress"] = {
        {"last", stress.last}, {"mean", mean_stress_error()}, {"worst", stress.worst}};
  return out;
}

}  // namespace grus::app
