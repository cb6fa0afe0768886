// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/standing.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "dem/base/error.hpp"

namespace grus::app {
namespace {

std::string hex(double v) { return fmt::format("{:a}", v); }  // exact
double unhex(const nlohmann::json& v) {
  const double x = std::strtod(v.get<std::string>().c_str(), nullptr);
  if (!std::isfinite(x)) throw dem::InputError("checkpoint.h5: checkpoint is damaged: where the run stands");
  return x;
}

nlohmann::json energies(const fem::MacroEnergy& e) {
  return {hex(e.kinetic), hex(e.internal), hex(e.external), hex(e.viscous),
          hex(e.work),    hex(e.largest),  hex(e.damped),   hex(e.scaled)};
}

fem::MacroEnergy energies_of(const nlohmann::json& e) {
  return {unhex(e.at(0)), unhex(e.at(1)), unhex(e.at(2)), unhex(e.at(3)),
          unhex(e.at(4)), unhex(e.at(5)), unhex(e.at(6)), unhex(e.at(7))};
}

}  // namespace

nlohmann::json save(const fem::IncrementReport& r) {
  return {{"load_factor", hex(r.load_factor)},
          {"next_size", hex(r.next_size)},
          {"increments", r.increment},
          {"sweeps", r.law_sweeps},
          {"largest_force", hex(r.largest_force)},
          {"stiffest", hex(r.stiffest)},
          {"last_size", hex(r.last_size)},
          {"energy", energies(r.energy)}};
}

nlohmann::json save(const fem::DynamicsReport& r) {
  return {{"time", hex(r.time)},
          {"dt", hex(r.dt)},
          {"steps", r.steps},
          {"dissipated", hex(r.dissipated)},
          {"energy", energies(r.energy)}};
}

nlohmann::json save(const fem::ExplicitStaticsReport& r) {
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

void load(const nlohmann::json& at, fem::StaticsStart& s) {
  s = {unhex(at.at("load_factor")),   unhex(at.at("next_size")),
       at.at("increments"),           at.at("sweeps"),
       unhex(at.at("largest_force")), unhex(at.at("stiffest")),
       unhex(at.at("last_size")),     energies_of(at.at("energy"))};
}

void load(const nlohmann::json& at, fem::DynamicsReport& s) {
  s = {unhex(at.at("time")), unhex(at.at("dt")), at.at("steps"), energies_of(at.at("energy")),
       unhex(at.at("dissipated"))};
}

void load(const nlohmann::json& at, fem::ExplicitStaticsReport& s) {
  s.load_factor = unhex(at.at("load_factor"));
  s.rate = unhex(at.at("rate"));
  s.mean_rate = unhex(at.at("mean_rate"));
  s.steps = at.at("steps");
  s.settling = at.at("settling");
  s.rested = at.at("rested");
  s.energy = energies_of(at.at("energy"));
  s.unbalanced = unhex(at.at("unbalanced")), s.largest_unbalanced = unhex(at.at("largest_unbalanced"));
  s.inertial_number = unhex(at.at("inertial_number"));
  for (std::size_t k = 0; k < 3; ++k) s.sums[k] = unhex(at.at("sums").at(k));
  s.counted = at.at("counted"), s.governor = at.at("governor").get<fem::Governor>();
}

}  // namespace grus::app
