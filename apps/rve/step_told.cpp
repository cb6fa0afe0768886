// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/step_told.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "dem/motion/inertia_by_step.hpp"

namespace grus::app {

void StepTold::add(const dem::Model& model, const dem::State& s, double rate, double pressure) {
  if (first == 0) first = least = s.dt;
  if (s.dt < least) {
    least = s.dt, least_at = s.time;
    if (first > told_fall * least) slowest = dem::critical_grain(model, s);
  }
  if (model.numerics.inertia_step == 0) return;
  const dem::AddedInertia added = dem::added_inertia(s.grains);
  mass.add(added.mass), moment.add(added.moment);
  heavier = added.heavier, slower = added.slower;
  if (!(pressure > 0)) return;
  const double number = dem::largest_inertial_number(s.grains, std::abs(rate), pressure);
  if (number > inertial_number || pressure > barely_loaded * pressure_then)
    inertial_number = number, pressure_then = pressure;
}

nlohmann::json StepTold::json() const {
  return {{"added_mass", {{"last", mass.last}, {"worst", mass.worst}}},
          {"added_moment", {{"last", moment.last}, {"worst", moment.worst}}},
          {"heavier_grains", heavier},
          {"slower_grains", slower},
          {"largest_inertial_number", pressure_then > 0 ? nlohmann::json(inertial_number) : nlohmann::json()}};
}

namespace {

std::string why_short(const dem::CriticalGrain& g) {
  const char* const how = std::isnan(g.turning) ? "it is fast" : g.turning > 0.5 ? "it could turn fast" : "it is light";
  return fmt::format("grain {}, diameter {:.3g} m, least width {:.3g} m, needs the short one as {}", g.id, g.diameter,
                     g.width, how);
}

}  // namespace

std::vector<std::string> StepTold::notes(bool by_step, bool solved) const {
  std::vector<std::string> all;
  if (first > told_fall * least) {
    const std::string why = solved ? "contacts changed too fast for longer steps" : why_short(slowest);
    all.push_back(
        fmt::format("the time step has fallen from {:.3g} to {:.3g} s (t = {:.4g} s): {}{}", first, least, least_at,
                    why, by_step || solved ? "" : "; in slow tests numerics.inertia.step makes such grains heavier"));
  }
  if (by_step && inertial_number > most_inertial_number)
    all.push_back(
        fmt::format("inertia by step: the largest inertial number of a grain was {:.2g}: it resists its motion, too; "
                    "lower numerics.inertia.step, or load more slowly",
                    inertial_number));
  if (by_step && std::max(mass.worst, moment.worst) > most_added)
    all.push_back(fmt::format(
        "inertia by step: the grains' masses were {:.3g} times, their moments of inertia {:.3g} times those of the "
        "solids (worst row): what moves them may show in every force; lower numerics.inertia.step until it does not",
        1 + mass.worst, 1 + moment.worst));
  return all;
}

}  // namespace grus::app
