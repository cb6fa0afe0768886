// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/real_time.hpp"

#include <algorithm>
#include <utility>

#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"

namespace grus::dem {

void stretch_in_time(const Model& model, State& state, const Mat3& u, double duration, Team& team,
                     const std::function<void(double)>& begun) {
  const double end = state.time + duration;
  Cell& cell = state.boundary.cell;
  const Mat3 start = cell.began(), target = u * start;
  set_cell_rate(state, cell.of_began((target - start) / duration));
  bool first = begun != nullptr;
  for (double left = duration; left > 1e-9 * duration; left = end - state.time) {
    update_time_step(model, state, team);
    const auto due = static_cast<std::uint64_t>(std::max(1.0, std::ceil(left / state.dt * (1 - 1e-12))));
    std::uint64_t steps = model.numerics.time_step > 0
                              ? due
                              : std::min(due, std::max<std::uint64_t>(1, state.next_estimate - state.steps));
    if (first) steps = 1;
    const double safe = state.dt;
    state.dt = left / static_cast<double>(due);
    run_steps(model, state, steps, team);  // ends early at a breakage: fragments may need a smaller step
    state.dt = safe;
    if (std::exchange(first, false)) begun(1 / static_cast<double>(due));
  }
  state.time = end;
  cell.vectors = cell.of_began(target);  // differs by round-off only
}

void deform_in_time(const Model& model, State& state, const Mat3& deformation, double duration, Team& team) {
  Mat3 r, u;
  polar(deformation, r, u);
  stretch_in_time(model, state, u, duration, team);
  if (!(r - Mat3::Identity()).isZero(1e-15)) rotate(state, r);
}

Response respond_in_time(const Model& model, State& state, const Mat3& deformation, double duration, bool tangent,
                         Team& team) {
  Response response;
  const std::uint64_t first = state.steps;
  const std::size_t broken = state.ledger.breakages;
  if (duration > 0) deform_in_time(model, state, deformation, duration, team);
  check_sanity(model, state);
  response.stress = love_weber(state, state.boundary.cell.volume());
  response.stable = true;
  response.steps = state.steps - first;
  response.breakages = state.ledger.breakages - broken;
  response.work = state.ledger.work;
  if (tangent) add_tangent(model, state, response);
  return response;
}

}  // namespace grus::dem
