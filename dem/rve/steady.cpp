// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/steady.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "dem/base/error.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/real_time.hpp"
#include "dem/rve/step.hpp"

namespace grus::dem {
namespace {

constexpr double fading = 0.97;  // of the reach, an increment
constexpr std::uint64_t checked_every =
    256;  // steps between looks at overlaps and energy, which cost as much as a step

}  // namespace

Response respond_steadily(const Model& model, const QuasiStatic& o, State& state, Steady& steady,
                          const Mat3& deformation, bool tangent, Team& team) {
  Response response;
  const std::uint64_t first = state.steps;
  const std::size_t broken = state.ledger.breakages;
  Mat3 r, u;
  polar(steady.turn.transpose() * deformation * steady.turn, r, u);
  if (steady.breakages == UINT64_MAX) steady.stress = parted_stress(state).rest;
  if (steady.breakages != state.ledger.breakages) {
    steady.breakages = state.ledger.breakages;
    steady.inertia = inertial_number(state, 1, 1);
  }
  const double strain = (u - Mat3::Identity()).norm(),
               pressure = std::max({mean_pressure(steady.stress), o.pressure_floor, 1e-9});
  if (!(strain <= Rve::most_stretch))
    throw Unstable(fmt::format("an increment of strain {:.3g}; one may strain by {:g}: take a smaller one", strain,
                               Rve::most_stretch));
  const double per_rate = steady.inertia / std::sqrt(pressure);
  update_time_step(model, state, team);
  steady.reach = std::max(strain, fading * steady.reach);
  const double duration =
      std::max({state.dt, steady.reach * per_rate / o.inertial_number, steady.reach / o.strain_per_step * state.dt});
  Mat3 viscous = steady.viscous, haste = Mat3::Zero();  // haste: Pa, mean of the dashpots' stress over the increment
  double left = 1;
  PartedStress now;
  auto begun = [&](double part) {
    now = parted_stress(state);  // dashpots are those of the new rate from its first step on
    haste = 0.5 * part * (viscous + now.dashpots), viscous = now.dashpots, left -= part;
  };
  stretch_in_time(model, state, u, duration, team, std::ref(begun));
  if (state.steps / checked_every != first / checked_every) check_sanity(model, state);
  steady.turn = steady.turn * r;
  if (left > 0) now = parted_stress(state);  // of a single step it is known
  haste += 0.5 * left * (viscous + now.dashpots);
  steady.haste += state.boundary.cell.volume() * haste.cwiseProduct(u - Mat3::Identity()).sum();
  steady.viscous = now.dashpots;
  steady.stress = now.rest;
  response.stress = steady.turn * steady.stress * steady.turn.transpose();
  response.stable = true;
  response.steps = state.steps - first;
  response.breakages = state.ledger.breakages - broken;
  response.work = steady.work = state.ledger.work;
  response.haste = steady.haste;
  response.inertial_number = strain / duration * per_rate;
  if (tangent) {
    add_tangent(model, state, response);
    response.tangent = turned(response.tangent, steady.turn);
  }
  return response;
}

State in_space(State state, const Steady& steady) {
  if (steady.turn != Mat3::Identity()) rotate(state, steady.turn);
  return state;
}

}  // namespace grus::dem
