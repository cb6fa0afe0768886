// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/implicit_stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "dem/base/error.hpp"
#include "dem/contact/forces.hpp"
#include "dem/contact/way_bound.hpp"
#include "dem/rve/cone_rows.hpp"
#include "dem/rve/passes.hpp"
#include "dem/rve/renew_list.hpp"

namespace grus::dem {
namespace {

constexpr ConeSettings settings{.tolerance = 1e-4, .iterations = 2000, .corrections = 1};
constexpr int many = 300;             // iterations of a step that is too long
constexpr double approach = 0.1;      // in a step, of the overlap, both weighted by the contacts' forces
constexpr std::uint64_t between = 5;  // steps between estimates of the step
constexpr std::uint64_t halved = 0;   // as estimate_interval: the solver had to work for long

/// The step in which contacts move by a share of their overlap (s); infinite where none does.
double step_by_approach(const State& s) {
  const Contacts& c = s.contacts;
  double overlap = 0, speed = 0;
  for (std::size_t k = 0; k < c.size(); ++k) {
    if (!c.contact.touching(k)) continue;
    const Pair& p = c.pair[k];
    Vec3 v = -s.grains.motion[p.a].velocity;
    if (k >= c.begin[first_wall])
      v += s.boundary.walls[p.b].velocity;
    else
      v += s.grains.motion[p.b].velocity + s.boundary.cell.rate * Vec3(p.image[0], p.image[1], p.image[2]);
    const double force = c.touch[k].force.norm();
    overlap += force * c.touch[k].overlap, speed += force * std::abs(c.touch[k].normal.dot(v));
  }
  return speed > 0 ? approach * overlap / speed : INFINITY;
}

void choose_time_step(const Model& model, State& state) {
  if (state.steps < state.next_estimate) return;
  const Numerics& n = model.numerics;
  if (n.time_step > 0) {
    state.dt = n.time_step, state.next_estimate = std::numeric_limits<std::uint64_t>::max();
    return;
  }
  const bool long_work = state.estimate_interval == halved;
  const double wanted = std::min(step_by_approach(state), n.max_time_step > 0 ? n.max_time_step : INFINITY);
  state.dt = long_work ? 0.5 * state.dt : std::min(2 * state.dt, std::max(0.5 * state.dt, wanted));
  state.estimate_interval = long_work ? 4 * between : between;
  state.next_estimate = state.steps + state.estimate_interval;
}

/// Explicit steps' preparation; then the step grows from theirs.
void make_ready(const Model& model, State& state, Team& team) {
  explicit_stepper.prepare(model, state, team);
  state.estimate_interval = between, state.next_estimate = state.steps;
  choose_time_step(model, state);
}

void book(State& state) {
  const BlockEnergy contacts = flush(state.contacts);
  for (auto& e : state.grain_energy) e = {.speed2 = e.speed2};
  book(contacts, state.ledger);
}

/// Room of a run.
struct Room {
  ConeSolver solver;
  ConeSystem system;
  std::vector<ConeRows> impulse;
};

/// What the press of contact k held and its dashpot has not taken, less what it gave to the grains on its way (m)
/// apart. One that parts gives no more than it held.
double lost_by_press(const ConeSystem& system, std::size_t k, double dt, double viscous, double impulse, double way) {
  const double held = system.held[k][press_row], stiffness = system.stiffness[k], given = impulse / dt * way;
  const double after = held - stiffness * way;
  if (after <= 0) return system.energy[k] - given;
  return 0.5 * (held + after) * way + 0.5 * (viscous + impulse / dt - after) * way - given;
}

/// Impulses of the step to come, as forces that the sweep takes for half a step; returns the solver's iterations.
/// Booked is what implicit Euler loses: 1/2 dv M dv of the grains, and of each row half the change of its force times
/// its way. Gravity does its work at the end's velocity.
int solve_step(const Model& model, State& state, double dt, Team& team, Room& room) {
  Grains& g = state.grains;
  ConeSystem& system = room.system;
  fill(model, state, dt, team, system);
  const Vec3 fall = dt * model.motion.gravity;
  std::vector<ConeContact>& contacts = system.contact;
  room.impulse.resize(contacts.size());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ConeContact& c = contacts[k];
    for (std::size_t j = 0; j < cone_rows; ++j) room.impulse[k][j] = dt * system.held[k][j];
    if (c.b != ConeContact::fixed || fall.isZero(0)) continue;  // two that fall do not meet faster
    const ConeRows added{-c.normal.dot(fall), -c.across.dot(fall), -c.normal.cross(c.across).dot(fall)};
    for (std::size_t j = 0; j < spin_row; ++j) c.free[j] += added[j], system.moved[k][j] += added[j];
  }
  const ConeEnd end = room.solver.solve(system.body, contacts, settings, room.impulse, team);
  if (!(end.residual <= settings.tolerance))
    throw Unstable(
        fmt::format("implicit step of {:.3g} s: the forces of {} contacts are not found in {} iterations "
                    "(residual {:.2g}, asked {:g}), at t = {:.6g} s: lower numerics.max_time_step",
                    dt, contacts.size(), end.iterations, end.residual, settings.tolerance, state.time));
  const auto& change = room.solver.changes(system.body, contacts, room.impulse, team);
  double lost = 0, work = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ConeContact& c = contacts[k];
    const ConeRows& before = system.moved[k];
    const ConeRows by = room.solver.moved(c);
    lost += lost_by_press(system, k, dt, state.contacts.contact.viscous[system.pair[k]], room.impulse[k][press_row],
                          dt * (before[press_row] + by[press_row]));
    for (std::size_t j = slide_row; j < cone_rows; ++j)
      lost += 0.5 * (system.held[k][j] * dt - room.impulse[k][j]) * (before[j] + by[j]);
  }
  for (std::size_t i = 0; i < g.size(); ++i) {
    const Vec3 kick = change[i].velocity + fall, turn = inertia_tensor(g, i) * change[i].spin;
    lost += 0.5 * (g.mass[i] * kick.squaredNorm() + turn.dot(change[i].spin));
    work += g.mass[i] * fall.dot(g.motion[i].velocity + kick);
    g.force[i] = 2 / dt * g.mass[i] * kick, g.torque[i] = 2 / dt * turn;
  }
  state.ledger.damping += lost, state.ledger.local_damping += lost;
  state.ledger.work += work;
  return end.iterations;
}

std::uint64_t run(const Model& model, State& state, std::uint64_t count, Team& team) {
  Grains& g = state.grains;
  MotionSettings free = model.motion;  // gravity is in the impulses
  free.gravity.setZero();
  const Cell& cell = state.boundary.cell;
  if (cell.periodic() && !cell.rate.isZero(0)) free.affine = cell.rate * cell.vectors.inverse();
  const PassList passes = passes_of(model, state);
  const double dt = state.dt;
  Step step{model, state, team, dt};
  WayBound bound(g, free.affine, dt);
  Room room;
  std::uint64_t k = 0;
  const auto finish = [&] {
    book(state);
    state.ledger.most_work = std::max(state.ledger.most_work, std::abs(state.ledger.work));
    state.grain_steps += k * g.size();
    if (state.contacts.index.first.empty()) index_grains(g.size(), state.contacts, state.reference.room.next);
  };
  while (k < count) {
    const int iterations = solve_step(model, state, dt, team, room);
    sweep(Kick::open, g, state.contacts, free, false, dt, state.grain_energy, team);
    double& way = state.reference.travelled;
    way += bound.of_step(k, 1.1 * take_speed(state.grain_energy), way);
    move_boundary(state.boundary, dt);
    if (const ListState found = look_at_list(g, state.boundary, state.reference); found != ListState::holds)
      renew_list(model, state, found, passes.indexes(), team);
    const bool due = passes.due(state);
    for (const Pass* pass : passes)
      if (pass->before_forces) pass->before_forces(step);
    contact_forces(model.law, model.pairs, g, state.boundary, dt, true, state.contacts, team);
    sweep(Kick::close, g, state.contacts, model.motion, false, 0, state.grain_energy, team);
    for (const Pass* pass : passes)
      if (pass->after_forces) pass->after_forces(step);
    ++state.steps, ++k;
    state.time += dt;
    for (const Pass* pass : passes) {
      if (!due || !pass->stops || !pass->stops(step)) continue;
      finish();
      pass->conclude(step);
      if (model.numerics.time_step == 0) state.next_estimate = state.steps;
      return k;
    }
    if (iterations <= many || model.numerics.time_step > 0) continue;
    state.estimate_interval = halved, state.next_estimate = state.steps;
    break;
  }
  finish();
  return k;
}

}  // namespace

const Stepper implicit_stepper{make_ready, choose_time_step, run};

}  // namespace grus::dem
