// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "dem/base/error.hpp"
#include "dem/bond/bonds.hpp"
#include "dem/bond/supports.hpp"
#include "dem/contact/forces.hpp"
#include "dem/motion/integrate.hpp"
#include "dem/rve/rigid_stepper.hpp"

namespace grus::dem {
namespace {

/// Softening is summed exactly: what it has taken may fall by round-off alone (of energy_scale).
constexpr double fracture_error = 1e-9;

}  // namespace

void set_cell_rate(State& state, const Mat3& rate) {
  Cell& cell = state.boundary.cell;
  const Mat3 jump = (rate - cell.rate) * cell.vectors.inverse();
  const bool started = cell.rate.isZero(0);
  cell.rate = rate;
  if (jump.isZero(0)) return;
  if (started && state.next_estimate != std::numeric_limits<std::uint64_t>::max()) state.next_estimate = state.steps;
  double gained = 0;
  for (std::size_t i = 0; i < state.grains.size(); ++i) {
    Motion& m = state.grains.motion[i];
    const Vec3 dv = jump * m.position;
    gained += state.grains.mass[i] * dv.dot(m.velocity + 0.5 * dv);
    m.velocity += dv;
  }
  state.ledger.work += gained;
}

void rotate(State& state, const Mat3& r) {
  Grains& g = state.grains;
  const Quat q(r);
  for (std::size_t i = 0; i < g.size(); ++i) {
    Motion& m = g.motion[i];
    m.position = r * m.position;
    m.velocity = r * m.velocity;
    m.spin = r * m.spin;
    g.orientation[i] = unit(q * g.orientation[i]);
    g.angular_momentum[i] = r * g.angular_momentum[i];
    g.force[i] = r * g.force[i], g.torque[i] = r * g.torque[i];
  }
  update_frames(g);
  auto& springs = state.contacts.contact;
  for (std::size_t k = 0; k < springs.stiffness.size(); ++k) {
    Contact c = springs[k];
    for (Vec3& spring : c.spring) spring = r * spring;
    springs.set(k, c);
  }
  for (auto& t : state.contacts.touch) t.normal = r * t.normal, t.force = r * t.force;
  for (Spot& spot : state.contacts.spot) spot.at = r * spot.at, spot.couple = r * spot.couple;
  for_each_bond(state.bonds, [&](auto& bond) { bond.force = r * bond.force; });
  for (FaceBond& bond : state.bonds.face.row) bond.shear = r * bond.shear;
  for (FaceDashpot& d : state.bonds.dashpot) d.force = r * d.force, d.couple = r * d.couple;
  for (Handed& h : state.bonds.handed) h.shear = r * h.shear;
  Cell& cell = state.boundary.cell;
  cell.vectors = r * cell.vectors, cell.rate = r * cell.rate;
  state.reference.cell = r * state.reference.cell;
  for (auto& x : state.reference.position) x = r * x;
  for (auto& o : state.reference.orientation) o = unit(q * o);
}

BlockEnergy refresh_forces(const Model& model, State& state, Team& team) {
  contact_forces(model.law, model.pairs, state.grains, state.boundary, 0, true, state.contacts, team);
  const BlockEnergy taken = flush(state.contacts);
  if (!state.bonds.empty()) {
    bond_forces(state.grains, state.boundary.cell, state.bonds, state.ledger, team);
    support_forces(state.grains, state.boundary, state.bonds, state.ledger, state.time);
  }
  std::vector<SweepEnergy> none;
  sweep(Kick::close, state.grains, state.contacts, model.motion, !state.bonds.empty(), 0, none, team);
  return taken;
}

bool grains_rub(const Model& model) {
  return std::any_of(model.pairs.begin(), model.pairs.end(),
                     [](const PairLaw& p) { return p.friction[slide_spring] > 0; });
}

void drop_slide_springs(Contacts& contacts) {
  ContactColumns& c = contacts.contact;
  for (auto& column : c.spring[slide_spring]) std::fill(column.begin(), column.end(), 0.0);
  std::fill(c.compliance.begin(), c.compliance.end(), 0.0);
}

double stored_energy(const Model& model, const State& state) {
  return kinetic_energy(state.grains) + elastic_energy(model.law, state.contacts) + stored_energy(state.bonds);
}

bool exchanged(const State& state) {
  constexpr std::size_t first_steps = 20;
  return state.grain_steps >= first_steps * state.grains.size();
}

double told_energy_error(const State& state, double stored) {
  return exchanged(state) ? energy_error(state.ledger, stored) : 0;
}

namespace {

/// What makes steps shorter: where the step is held, safety does nothing; nor with steps that solve their contacts.
std::string knob(const Model& model) {
  const Numerics& n = model.numerics;
  if (n.time_step == 0 && model.stepper->long_steps)
    return n.max_time_step > 0 ? fmt::format("numerics.max_time_step (now {:g} s)", n.max_time_step)
                               : "numerics.max_time_step (now none), or take explicit steps";
  return n.time_step > 0 ? fmt::format("numerics.time_step (now {:g} s)", n.time_step)
                         : fmt::format("numerics.safety (now {:g})", n.safety);
}

}  // namespace

void check_sanity(const Model& model, const State& state) {
  check_sanity(model, state, stored_energy(model, state), deepest_contact(state.grains, state.contacts));
}

void check_sanity(const Model& model, const State& state, double stored, const DeepestContact& deepest) {
  if (!std::isfinite(stored) && state.steps == 0)
    throw Unstable(
        "energy is not finite at the start: some size, stiffness, density or speed of the scene is out of all bounds");
  if (!std::isfinite(stored))
    throw Unstable(
        fmt::format("energy is not finite at t = {:.6g} s (step {}): lower {}", state.time, state.steps, knob(model)));
  if (deepest.ratio > model.overlap_limit()) {
    const Pair& p = state.contacts.pair[deepest.pair];
    const bool wall = deepest.pair >= state.contacts.begin[first_wall];
    throw Unstable(fmt::format(
        "overlap of grain {} and {} {} is {:.0f} % of a radius at t = {:.6g} s (limit {:.0f} %): {}",
        state.grains.id[p.a], wall ? "wall" : "grain", wall ? p.b : state.grains.id[p.b], 100 * deepest.ratio,
        state.time, 100 * model.overlap_limit(),
        model.stepper == &rigid_stepper ? "they do not give way: move them apart at the start, or lower "
                                          "numerics.max_time_step"
                                        : "stiffen the material, load less, or raise numerics.max_overlap"));
  }
  const Ledger& l = state.ledger;
  const double scale = energy_scale(l, stored);
  auto refuse = [&](const char* what, double joules, double share = least_dissipation_error) {
    if (joules > share * scale)
      throw Unstable(fmt::format("{} by {:.3g} J ({:.2g} of the work) at t = {:.6g} s: lower {}", what, joules,
                                 joules / scale, state.time, knob(model)));
  };
  if (std::isfinite(model.numerics.max_energy_error)) {
    refuse("the energy taken by friction has fallen", l.most_friction - l.friction);
    refuse("the energy taken by damping has fallen", l.most_damping - l.damping);
    refuse("the energy taken by fracture has fallen", l.most_fracture - l.fracture, fracture_error);
    refuse("splits have added energy to the contacts", l.split_added);
    refuse("fines have taken a negative kinetic energy", -l.fines.kinetic);
    refuse("springs, splits and spins have lost or won energy for no known reason", std::abs(l.unexplained),
           model.numerics.max_energy_error);
  }
  const double error = told_energy_error(state, stored);
  if (std::abs(error) > model.numerics.max_energy_error)
    throw Unstable(fmt::format("energy error is {:.1f} % at t = {:.6g} s (limit {:.0f} %): lower {}", 100 * error,
                               state.time, 100 * model.numerics.max_energy_error, knob(model)));
}

}  // namespace grus::dem
