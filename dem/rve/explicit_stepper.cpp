// SPDX-License-Identifier: LGPL-3.0-or-later
// The explicit stepper: kick, drift, boundary, neighbour list, contacts, kick, and what the scene adds to it.
#include "dem/rve/stepper.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>

#include "dem/base/error.hpp"
#include "dem/bond/bonds.hpp"
#include "dem/bond/supports.hpp"
#include "dem/contact/forces.hpp"
#include "dem/contact/way_bound.hpp"
#include "dem/motion/critical_step.hpp"
#include "dem/motion/inertia_by_step.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/passes.hpp"
#include "dem/rve/renew_list.hpp"
#include "dem/rve/rough_walls.hpp"
#include "dem/rve/step.hpp"

namespace grus::dem {
namespace {

MotionSettings settings_of(const Model& model, const State& state) {
  MotionSettings s = model.motion;
  s.damping = model.damping;
  s.affine = state.boundary.cell.gradient();
  return s;
}

void book(State& state) {
  const BlockEnergy contacts = flush(state.contacts);
  SweepEnergy grains;
  for (auto& e : state.grain_energy) {
    grains.viscous += e.viscous, grains.work += e.work;
    e = {.speed2 = e.speed2};
  }
  state.ledger.damping += grains.viscous;
  state.ledger.local_damping += grains.viscous;
  state.ledger.work += grains.work;
  book(contacts, state.ledger);
}

/// Forces of all contacts, and the kicks that they give. A tile of grains may move as soon as its pairs and those that
/// earlier tiles have with it are done (pairs belong to the lower tile: nothing later needs the tile where it is). A
/// thread moves its tiles while their data is at hand: it collects forces in a room that stays in its cache. One that
/// has nothing left takes from the others, from the back: sums are by tile, so it is all the same who makes them.
void force_and_move(const Model& model, State& state, const MotionSettings& settings, SleepingHulls* sleep, bool shown,
                    bool bonded, Kick kick, Team& team) {
  Contacts& c = state.contacts;
  const ContactPass contacts(model.law, model.pairs, state.grains, state.boundary, state.dt, shown, c, sleep);
  const SweepPass grains(kick, state.grains, c, settings, bonded, state.dt, state.grain_energy);
  const std::size_t n = state.grains.size(), tiles = tile_count(n), size = tile_size(n), words = tile_words(n);
  const std::uint32_t round = ++c.plan.round;
  c.plan.tile_load.resize(size * static_cast<std::size_t>(team.threads()));
  auto done = [&](std::size_t t) { return std::atomic_ref(c.plan.done[t]).load(std::memory_order_acquire) == round; };
  auto finish = [&](std::size_t t) { std::atomic_ref(c.plan.done[t]).store(round, std::memory_order_release); };
  auto waits = [&](std::size_t t) {  // for pairs of earlier tiles
    for (std::size_t w = 0; w < words; ++w)
      for (std::uint64_t wanted = c.plan.before[t * words + w]; wanted; wanted &= wanted - 1)
        if (!done(64 * w + static_cast<std::size_t>(std::countr_zero(wanted)))) return true;
    return false;
  };
  auto mine = [&](std::uint32_t& of) {  // one thread, once a round
    std::atomic_ref claim(of);
    return claim.load(std::memory_order_relaxed) != round && claim.exchange(round, std::memory_order_relaxed) != round;
  };
  auto move_ready = [&] {  // true: none is left
    bool all = true;
    for (std::size_t t = 0; t < tiles; ++t) {
      if (std::atomic_ref(c.plan.moved[t]).load(std::memory_order_relaxed) == round) continue;
      if (!done(t) || waits(t))
        all = false;
      else if (mine(c.plan.moved[t]))
        grains.tile(t, nullptr);
    }
    return all;
  };
  team.pieces(tiles, c.plan.tile_work, [&](std::size_t first, std::size_t last, int rank) {
    Load* const room = c.plan.tile_load.data() + size * static_cast<std::size_t>(rank);
    for (std::size_t t = first; t < last; ++t) {
      if (!mine(c.plan.taken[t])) continue;
      contacts.tile(t, room);
      const bool now = !waits(t) && mine(c.plan.moved[t]);  // nobody else claims it before it is done
      const std::size_t begin = t * size, end = std::min(n, begin + size);
      if (!now) {
        std::copy(room, room + (end - begin), c.plan.load.begin() + static_cast<std::ptrdiff_t>(begin));
        std::fill(room, room + (end - begin), Load{});
      }
      finish(t);
      if (now) grains.tile(t, room);
    }
    for (std::size_t t = tiles; t-- > 0;)
      if (mine(c.plan.taken[t])) contacts.tile(t, nullptr), finish(t);
    for (int spins = 0; !move_ready(); relax(spins)) {
    }
  });
}

/// Pairs of hulls sleep in runs of so many steps and more.
constexpr std::uint64_t worth_sleeping = 4;

/// All pairs of hulls wake. None is listed beyond 2.2 skins (mend.cpp), or opens by more than two while the list holds.
void wake(State& state) {
  state.reference.room.sleep.wake(state.grains, state.boundary.cell,
                                  state.contacts.begin[hull_hull + 1] - state.contacts.begin[hull_hull],
                                  2 * state.reference.largest + 6 * state.reference.skin);
}

/// What is below a strain of 1e-10 of all grains is round-off of their positions; what is below the first push that a
/// wall gives to a grain is a contact of few steps, in which the trapezoid of its work is coarse (J).
double energy_floor(const Model& model, const State& state) {
  const Grains& g = state.grains;
  double whole = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    const Material& m = model.materials[g.material[i]];
    whole += energy_of_strain(model.law, m.solid(), m.contact, g.extent[i].volume);
  }
  double fastest = 0;
  for (const Wall& wall : state.boundary.walls) fastest = std::max(fastest, wall.velocity.squaredNorm());
  return 1e-20 * whole + 0.5 * fastest * total_mass(g) / static_cast<double>(std::max<std::size_t>(g.size(), 1));
}

/// The eigenvalue (rad^2 s^-2) that the time step leaves to one contact of hulls; infinite where nobody looks.
double firmest_contact(const Model& model, const State& state) {
  if (state.grains.hull.empty() || model.numerics.time_step > 0) return INFINITY;
  const double omega = 2 * model.numerics.safety / state.dt;
  return omega * omega;
}

constexpr std::uint64_t least_ahead = 4;  // steps: what flies off from a contact and comes back still counts

/// The critical step of grains that have got the inertia for the step that is wanted; `stiffer`: some was short of it.
CriticalStep step_with_inertia(const Model& model, State& state, const HeldGrains& held, bool& stiffer) {
  const Numerics& numerics = model.numerics;
  Grains& g = state.grains;
  std::vector<double> floor(g.size());
  for (std::size_t i = 0; i < g.size(); ++i)
    floor[i] = numerics.inertia_factor(g.extent[i].equivalent_radius) * solid_mass(g, i);
  const double omega = 2 * numerics.safety / numerics.inertia_step;
  const GivenInertia given = give_inertia(held, omega * omega, floor, g);
  state.ledger.inertia += given.kinetic;
  stiffer = given.rise > 1 / (0.95 * 0.95);
  return critical_step(held, true, numerics.safety);
}

/// The step that was chosen bears all contacts as they are now.
void note_borne(const HeldGrains& held, Contacts& contacts) {
  for (const Bin bin : {hull_hull, hull_wall})
    for (std::size_t k = contacts.begin[bin]; k < contacts.begin[bin + 1]; ++k)
      contacts.contact.reach[k] = contacts.contact.touching(k) ? held.alone(k) : 0;
}

void choose_time_step(const Model& model, State& state, Team& team) {
  if (state.steps < state.next_estimate) return;
  const double before = state.dt;
  if (model.numerics.time_step > 0) {
    state.dt = model.numerics.time_step;
    state.next_estimate = std::numeric_limits<std::uint64_t>::max();
    return;
  }
  bool short_of = false;
  const double ahead = before * static_cast<double>(std::max<std::uint64_t>(least_ahead, state.estimate_interval));
  const HeldGrains held(model.law, model.pairs, model.materials.size(), state.grains, state.boundary, state.contacts,
                        state.bonds, ahead, team);
  const CriticalStep critical = model.numerics.inertia_step > 0 ? step_with_inertia(model, state, held, short_of)
                                                                : critical_step(held, false, model.numerics.safety);
  if (!std::isfinite(critical.dt))
    throw Unstable("no finite time step: the grains have no stiffness; give time_step in [numerics]");
  state.dt = std::min(model.numerics.safety * critical.dt, damped_safety * critical.damped);
  if (model.numerics.max_time_step > 0) state.dt = std::min(state.dt, model.numerics.max_time_step);
  // At once again while the stiffness grows, often while it changes, seldom while it does not.
  const bool steady = std::abs(state.dt - before) < 0.05 * before, stiffer = short_of || !(state.dt >= 0.95 * before);
  if (stiffer || before == 0)
    state.estimate_interval = 1;
  else if (!steady)
    state.estimate_interval = 5;
  else
    state.estimate_interval =
        std::min<std::uint64_t>(2 * state.estimate_interval, static_cast<std::uint64_t>(model.numerics.estimate_every));
  state.next_estimate = state.steps + state.estimate_interval;
  state.watch = StepWatch::on;
  note_borne(held, state.contacts);
}

void make_ready(const Model& model, State& state, Team& team) {
  Grains& g = state.grains;
  for (const Pass* pass : passes_of(model, state))
    if (pass->prepare) pass->prepare(model, state);
  update_frames(g);
  double mean_radius = 0;
  for (const Extent& e : g.extent) mean_radius += e.equivalent_radius;
  state.mean_radius = mean_radius / static_cast<double>(std::max<std::size_t>(g.size(), 1));
  state.skin = std::max(model.numerics.skin * state.mean_radius, contact_reach(model, state));
  state.listed_at = state.steps, state.sorted = g.size();
  refuse_small_cell(g, state.boundary.cell, state.skin);
  note_bonded(state);
  state.contacts.contact.keep(model.springs(), attracts(model.law) || of_hulls(model.law));
  build_contacts(g, state.boundary, state.skin, model.materials.size(), {}, state.contacts, state.reference, team);
  if (!grains_rub(model)) drop_slide_springs(state.contacts);  // of a preparation with friction
  contact_forces(model.law, model.pairs, g, state.boundary, 0, true, state.contacts, team);
  sweep(Kick::close, g, state.contacts, settings_of(model, state), false, 0, state.grain_energy, team);
  flush(state.contacts);
  state.next_estimate = state.steps;
  const double put_in = state.ledger.inertia;
  choose_time_step(model, state, team);
  state.ledger.inertia = put_in;  // the start counts with the inertia that it has got
  state.ledger.start = stored_energy(model, state);
  state.ledger.floor = energy_floor(model, state);
}

std::uint64_t run(const Model& model, State& state, std::uint64_t count, Team& team) {
  Grains& g = state.grains;
  const MotionSettings settings = settings_of(model, state);
  const PassList passes = passes_of(model, state);
  const double dt = state.dt;
  Step step{model, state, team, dt};
  WayBound bound(g, settings.affine, dt);
  Plan& plan = state.contacts.plan;
  plan.firmest = firmest_contact(model, state), plan.firmer = state.watch == StepWatch::firmer;
  SleepingHulls* const sleep = !g.hull.empty() && count >= worth_sleeping ? &state.reference.room.sleep : nullptr;
  if (sleep) wake(state);
  bool moving = false;  // positions already opened by the sweep of the step before
  const auto power = [&] {
    return boundary_power(state.boundary, state.contacts) + cell_power(state.boundary.cell, state.bonds) +
           support_power(state.boundary, state.bonds) + rough_power(model, state);
  };
  state.ledger.work += 0.5 * dt * power();
  auto finish = [&](std::uint64_t steps) {
    // The passes booked a whole dt.
    state.ledger.work -= 0.5 * dt * power();
    book(state);
    state.ledger.most_work = std::max(state.ledger.most_work, std::abs(state.ledger.work));
    state.grain_steps += steps * g.size();
    if (state.contacts.index.first.empty()) index_grains(g.size(), state.contacts, state.reference.room.next);
  };
  for (std::uint64_t k = 0; k < count; ++k) {
    if (!moving) sweep(Kick::open, g, state.contacts, settings, false, dt, state.grain_energy, team);
    double& way = state.reference.travelled;
    way += bound.of_step(k, 1.1 * take_speed(state.grain_energy), way);
    move_boundary(state.boundary, dt);
    if (sleep) sleep->go(g, state.boundary.cell, team);
    if (const ListState found = look_at_list(g, state.boundary, state.reference); found != ListState::holds) {
      renew_list(model, state, found, passes.indexes(), team);
      if (sleep) wake(state);
    }
    step.again = moving, step.pulled = false;
    const bool due = passes.due(state);
    const bool asks = plan.firmer > 0, last = asks || k + 1 == count;  // in the step before: however runs are cut
    moving = !due && !last;
    for (const Pass* pass : passes)
      if (pass->before_forces) pass->before_forces(step);
    force_and_move(model, state, settings, sleep, passes.shows() || !moving, step.pulled,
                   moving ? Kick::both : Kick::close, team);
    for (const Pass* pass : passes)
      if (pass->after_forces) pass->after_forces(step);
    ++state.steps;
    state.time += dt;
    if (due) {
      for (const Pass* pass : passes) {
        if (!pass->stops || !pass->stops(step)) continue;
        finish(k + 1);
        pass->conclude(step);
        if (model.numerics.time_step == 0) state.next_estimate = state.steps;
        return k + 1;
      }
    }
    if (!last) continue;
    finish(k + 1);
    if (asks)
      state.next_estimate = state.steps, state.watch = StepWatch::asked;
    else if (plan.firmer > 0)
      state.watch = StepWatch::firmer;
    return k + 1;
  }
  finish(0);
  return 0;
}

}  // namespace

const Stepper explicit_stepper{make_ready, choose_time_step, run};

}  // namespace grus::dem
