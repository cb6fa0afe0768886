// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/renew_list.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/bond/bonds.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/reduce_cell.hpp"
#include "dem/state/order.hpp"

namespace grus::dem {
namespace {

/// Fragments are born at the end of the columns, far from their neighbours. Where many have been, all grains are put in
/// the order in which they lie. Returns what index each comes from; nothing where they stay.
std::vector<Index> put_in_order(State& state) {
  Grains& g = state.grains;
  if (10 * g.size() < 11 * state.sorted) return {};
  std::vector<Index> order = order_in_space(g), place(g.size());
  reorder(g, order);
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<Index>(i);
  renumber(state.bonds, place);
  state.sorted = g.size();
  return order;
}

/// Before a list is made: a run that blows up must end here, not in a search over an endless box.
void check_speeds(const Model& model, const State& state) {
  for (std::size_t i = 0; i < state.grains.size(); ++i) {
    const Motion& m = state.grains.motion[i];
    if (m.velocity.norm() * state.dt < m.radius && std::isfinite(m.position.sum())) continue;
    throw Unstable(fmt::format(
        "grain {} moves at {:.3g} m/s, more than its radius in a step, at t = {:.6g} s: lower {}", state.grains.id[i],
        m.velocity.norm(), state.time,
        model.numerics.inertia_step > 0 ? "numerics.inertia.step" : "numerics.safety or numerics.time_step"));
  }
}

/// The third edge of a cell between walls grows as these part: no grain may meet an image across them.
void follow_walls(State& state) {
  Boundary& boundary = state.boundary;
  if (!boundary.cell.walled) return;
  double low = INFINITY, high = -INFINITY, largest = 0;
  for (const Wall& wall : boundary.walls) low = std::min(low, wall.point.z()), high = std::max(high, wall.point.z());
  for (const Motion& m : state.grains.motion)
    low = std::min(low, m.position.z()), high = std::max(high, m.position.z()), largest = std::max(largest, m.radius);
  if (heighten(boundary.cell, high - low, largest)) state.reference.room.anchor.clear();
}

}  // namespace

double contact_reach(const Model& model, const State& state) {
  if (!attracts(model.law)) return 0;
  double largest = 0;
  for (const Extent& e : state.grains.extent) largest = std::max(largest, e.equivalent_radius);
  return 1.01 * reach_of(model.law, model.pairs, largest);
}

void renew_list(const Model& model, State& state, ListState found, bool indexed, Team& team) {
  check_speeds(model, state);
  if (found == ListState::strays)
    return mend_contacts(state.grains, state.boundary, state.skin, model.materials.size(), state.reference.room.strays,
                         {}, state.contacts, state.reference, team, indexed);
  const std::uint64_t lasted = state.steps - state.listed_at, cost = 15 + 2 * state.reference.mends;
  const double usual = model.numerics.skin * state.mean_radius;
  const bool ran_out = !state.reference.stale;  // not broken bonds, which ask for a list at once
  if (ran_out && lasted < 8 * cost) state.skin = std::min(1.25 * state.skin, 2 * usual);
  if (ran_out && lasted > 40 * cost) state.skin = std::max(0.8 * state.skin, 0.5 * usual);
  state.skin = std::max(state.skin, contact_reach(model, state));
  state.listed_at = state.steps;
  const std::vector<Index> order = put_in_order(state);
  free_hulls(state.grains, state.boundary.walls, state.contacts.guesses);
  reduce_cell(state, model.numerics.reduce_cell_at);
  follow_walls(state);
  note_bonded(state);
  build_contacts(state.grains, state.boundary, state.skin, model.materials.size(), order, state.contacts,
                 state.reference, team, indexed);
  take_over(state);
}

}  // namespace grus::dem
