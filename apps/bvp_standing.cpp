// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp_standing.hpp"

#include <fmt/format.h>

#include <cstdlib>

namespace grus::app {
namespace {

std::string hex(double v) { return fmt::format("{:a}", v); }  // exact
double unhex(const nlohmann::json& v) { return std::strtod(v.get<std::string>().c_str(), nullptr); }

nlohmann::json energies(const fem::MacroEnergy& e) {
  return {hex(e.kinetic), hex(e.internal), hex(e.external), hex(e.viscous),
          hex(e.work),    hex(e.largest),  hex(e.damped),   hex(e.scaled)};
}

fem::MacroEnergy energies_of(const nlohmann::json& e) {
  return {unhex(e[0]), unhex(e[1]), unhex(e[2]), unhex(e[3]), unhex(e[4]), unhex(e[5]), unhex(e[6]), unhex(e[7])};
}

}  // namespace

nlohmann::json standing(const fem::IncrementReport& r) {
  return {{"load_factor", hex(r.load_factor)},
          {"next_size", hex(r.next_size)},
          {"increments", r.increment},
          {"sweeps", r.law_sweeps},
          {"largest_force", hex(r.largest_force)},
          {"stiffest", hex(r.stiffest)},
          {"last_size", hex(r.last_size)},
          {"energy", energies(r.energy)}};
}

nlohmann::json standing(const fem::DynamicsReport& r) {
  return {{"time", hex(r.time)},
          {"dt", hex(r.dt)},
          {"steps", r.steps},
          {"dissipated", hex(r.dissipated)},
          {"energy", energies(r.energy)}};
}

nlohmann::json standing(const fem::ExplicitStaticsReport& r) {
  return {{"load_factor", hex(r.load_factor)},
          {"rate", hex(r.rate)},
          {"mean_rate", hex(r.mean_rate)},
          {"steps", r.steps},
          {"settling", r.settling},
          {"rested", r.rested},
          {"energy", energies(r.energy)},
          {"unbalanced", hex(r.unbalanced)},
          {"largest_unbalanced", hex(r.largest_unbalanced)},
          {"inertial_number", hex(r.inertial_number)},
          {"sums", {hex(r.sums[0]), hex(r.sums[1]), hex(r.sums[2])}},
          {"counted", r.counted},
          {"governor", r.governor}};
}

void stand(const nlohmann::json& at, fem::StaticsStart& s) {
  s = {unhex(at["load_factor"]),   unhex(at["next_size"]), at["increments"],       at["sweeps"],
       unhex(at["largest_force"]), unhex(at["stiffest"]),  unhex(at["last_size"]), energies_of(at["energy"])};
}

void stand(const nlohmann::json& at, fem::DynamicsReport& s) {
  s = {unhex(at["time"]), unhex(at["dt"]), at["steps"], energies_of(at["energy"]), unhex(at["dissipated"])};
}

void stand(const nlohmann::json& at, fem::ExplicitStaticsReport& s) {
  s.load_factor = unhex(at["load_factor"]);
  s.rate = unhex(at["rate"]);
  s.mean_rate = unhex(at["mean_rate"]);
  s.steps = at["steps"];
  s.settling = at["settling"];
  s.rested = at["rested"];
  s.energy = energies_of(at["energy"]);
  s.unbalanced = unhex(at["unbalanced"]), s.largest_unbalanced = unhex(at["largest_unbalanced"]);
  s.inertial_number = unhex(at["inertial_number"]);
  for (std::size_t k = 0; k < 3; ++k) s.sums[k] = unhex(at["sums"][k]);
  s.counted = at["counted"], s.governor = at["governor"].get<fem::Governor>();
}

}  // namespace grus::app
