// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/passes.hpp"

#include <algorithm>

#include "dem/bond/supports.hpp"
#include "dem/rve/cut_bonds.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/rough_walls.hpp"

namespace grus::dem {
namespace {

void prepare_reshaping(const Model& model, State& state) {
  if (model.swells()) state.reference.radius.resize(state.grains.size());
}

/// Fragments that grow back to a breakable shape, or to the volume of their mass.
constexpr Pass growth{
    .wanted = [](const Model& model, const State&) { return model.reshapes(); },
    .indexes = true,
    .shows = true,
    .prepare = prepare_reshaping,
    .before_forces = [](Step& s) { reshape_fragments(s.model, s.state, s.dt, s.reshaping, s.team); },
    .after_forces = [](Step& s) { book_growth(s.model, s.state, s.reshaping); },
};

void pull_bonds(Step& s) {
  if (s.state.bonds.empty()) return;  // the last one has broken
  State& state = s.state;
  if (s.again) clear_supported(state.grains, state.bonds);
  double power = bond_forces(state.grains, state.boundary.cell, state.bonds, state.ledger, s.team, s.again, s.dt);
  power += support_forces(state.grains, state.boundary, state.bonds, state.ledger, state.time + s.dt);
  state.ledger.work += s.dt * power;
  s.pulled = true;
  if (state.bonds.handed.empty()) return;
  book_broken(state, s.model.records_bonds);
  if (!state.bonds.handed.empty()) state.reference.stale = true;
}

constexpr Pass bonds{
    .wanted = [](const Model&, const State& state) { return !state.bonds.empty(); },
    .before_forces = pull_bonds,
};

/// Work of what moves the grains of rough walls.
constexpr Pass rough_walls{
    .wanted = [](const Model&, const State& state) { return any_rough_moves(state.boundary); },
    .shows = true,
    .after_forces = [](Step& s) { s.state.ledger.work += s.dt * rough_power(s.model, s.state); },
};

void prepare_breakage(const Model& model, State& state) {
  Grains& g = state.grains;
  if (g.strength.empty()) {
    g.strength.resize(g.size());
    g.generation.resize(g.size(), 0);
    for (std::size_t i = 0; i < g.size(); ++i) draw_strength(model, g, i);
  }
  const bool rests = std::any_of(model.materials.begin(), model.materials.end(),
                                 [](const Material& m) { return m.fracture && m.fracture->limit.rest > 0; });
  if (rests && g.born.empty()) g.born.resize(g.size(), 0);
  state.contacts.spots = !g.hull.empty();
  draw_crystals(model, g);
  g.utilisation.assign(g.size(), NAN);
  if (model.tests_cracks()) g.held.assign(g.size(), {});
  const auto every = static_cast<std::uint64_t>(model.numerics.fracture_every);
  state.tested_at = state.steps, state.next_test = (state.steps / every + 1) * every;
}

bool look_for_breaks(Step& s) {
  if (!s.state.bonds.handed.empty()) return false;  // the next step's list takes over what broken bonds have left
  s.breaks = find_breaks(s.model, s.state, s.team);
  return !s.breaks.empty();
}

constexpr Pass breakage{
    .wanted = [](const Model& model, const State&) { return model.breakable(); },
    .indexes = true,
    .prepare = prepare_breakage,
    .due = [](const State& state) { return state.steps + 1 >= state.next_test; },
    .stops = look_for_breaks,
    .conclude =
        [](Step& s) {
          if (s.model.before_breaks) s.model.before_breaks(s.state, s.breaks);
          apply_breaks(s.model, s.state, s.breaks, s.team);
        },
};

constexpr std::array<const Pass*, 4> all{&growth, &bonds, &rough_walls, &breakage};

}  // namespace

bool PassList::indexes() const {
  return std::any_of(begin(), end(), [](const Pass* p) { return p->indexes; });
}

bool PassList::shows() const {
  return std::any_of(begin(), end(), [](const Pass* p) { return p->shows; });
}

bool PassList::due(const State& state) const {
  return std::any_of(begin(), end(), [&](const Pass* p) { return p->due && p->due(state); });
}

PassList passes_of(const Model& model, const State& state) {
  PassList list;
  for (const Pass* pass : all)
    if (pass->wanted(model, state)) list.add(pass);
  return list;
}

}  // namespace grus::dem
