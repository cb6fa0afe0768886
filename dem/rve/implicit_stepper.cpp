// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/implicit_stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "dem/base/error.hpp"
#include "dem/contact/forces.hpp"
#include "dem/contact/way_bound.hpp"
#include "dem/motion/critical_step.hpp"
#include "dem/rve/cone_rows.hpp"
#include "dem/rve/cone_steps.hpp"
#include "dem/rve/passes.hpp"
#include "dem/rve/renew_list.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {
namespace {

constexpr ConeSettings settings{.tolerance = 1e-4, .by_overlap = least_unbalanced, .iterations = 2000};
constexpr int patience = 10;          // times as many iterations for a step as short as it gets
constexpr int many = 1000;            // iterations of a step that may not grow
constexpr double approach = 0.1;      // in a step, of the overlap, both weighted by the contacts' forces
constexpr double wrong = 0.02;        // forces at the end of a step that is too long, as `missed` tells
constexpr double useless = 0.05;      // the same, of a step that is taken back
constexpr double made = 1e-3;         // energy that a step may make of nothing, of what contacts hold
constexpr double flight = 0.01;       // in a step, of the mean radius
constexpr std::uint64_t between = 5;  // steps between estimates of the step

/// The step in which contacts move by a share of their overlap, and what flies by one of its radius (s); infinite where
/// nothing moves.
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
      v += s.grains.motion[p.b].velocity + at_image(s.boundary.cell.rate, p.image);
    const double force = c.touch[k].force.norm();
    overlap += force * c.touch[k].overlap, speed += force * std::abs(c.touch[k].normal.dot(v));
  }
  double fastest2 = 0;
  for (const Motion& m : s.grains.motion) fastest2 = std::max(fastest2, m.velocity.squaredNorm());
  const double met = fastest2 > 0 ? flight * s.mean_radius / std::sqrt(fastest2) : INFINITY;
  return std::min(met, speed > 0 ? approach * overlap / speed : INFINITY);
}

}  // namespace

ConeSettings accuracy_of(const State& state, double dt) {
  ConeSettings of = settings;
  of.wish = std::clamp(dt / step_by_approach(state), 0.03, 1.0);
  if (state.watch == StepWatch::off) of.iterations *= patience;
  return of;
}

namespace {

/// No step is shorter than those of the explicit stepper (s).
double shortest_step(const Model& model, const State& s, Team& team) {
  const HeldGrains held(model.law, model.pairs, model.materials.size(), s.grains, s.boundary, s.contacts, s.bonds, 0,
                        team);
  return model.numerics.safety * critical_step(held, false).dt;
}

/// state.watch says how the steps since the last estimate went. on: well; asked: it may not grow; firmer: it was too
/// long; off: it is as short as it gets.
void choose_time_step(const Model& model, State& state, Team& team) {
  if (state.steps < state.next_estimate) return;
  const Numerics& n = model.numerics;
  if (n.time_step > 0) {
    state.dt = n.time_step, state.next_estimate = std::numeric_limits<std::uint64_t>::max();
    return;
  }
  const double wanted = std::min(step_by_approach(state), n.max_time_step > 0 ? n.max_time_step : INFINITY);
  const bool shorter = state.watch == StepWatch::firmer || wanted < state.dt;
  if (shorter) {
    const double half = 0.5 * state.dt, shortest = shortest_step(model, state, team);
    state.dt = std::max(state.watch == StepWatch::firmer ? half : std::max(half, wanted), shortest);
    state.watch = state.dt > shortest ? StepWatch::on : StepWatch::off;
  } else {
    if (state.watch != StepWatch::asked) state.dt = std::min(2 * state.dt, wanted);
    state.watch = StepWatch::on;
  }
  if (n.max_time_step > 0) state.dt = std::min(state.dt, n.max_time_step);
  state.estimate_interval = between, state.next_estimate = state.steps + between;
}

/// Explicit steps' preparation; then the step grows from theirs.
void make_ready(const Model& model, State& state, Team& team) {
  explicit_stepper.prepare(model, state, team);
  state.next_estimate = state.steps, state.watch = StepWatch::on;
  choose_time_step(model, state, team);
}

void book(State& state) {
  BlockEnergy contacts = flush(state.contacts);
  contacts.work = 0;  // that of the impulses is booked: the forces at the end of a step have not acted yet
  for (auto& e : state.grain_energy) e = {.speed2 = e.speed2};
  book(contacts, state.ledger);
}

/// Room of a run.
struct Room {
  ConeSolver solver;
  ConeSystem system;
  std::vector<ConeRows> impulse;
  std::vector<Vec3> taken;  // N: twice the mean force on each grain in the step
  double pressed = 0;       // N, of all contacts
  double lost = 0;          // J, by the scheme in the step
  State before;             // of a step that may have to be taken back
};

/// Work of the springs along the plane and of the dashpot in half a step, at this velocity (J).
double half_work(const HeldContact& of, const ConeRows& velocity, double dt) {
  double power = of.viscous * velocity[press_row];
  for (std::size_t j = slide_row; j < rock_row; ++j) power += of.held[j] * velocity[j];
  return 0.5 * dt * power;
}

/// In a step as short as an explicit one what overlaps say is made up for in the next: shorter ones are none.
bool found(const State& state, const ConeEnd& end) {
  return state.watch == StepWatch::off ? end.residual <= settings.tolerance : end.found(settings);
}

/// Impulses of the step to come, as forces that the sweep takes for half a step.
/// Booked is what implicit Euler loses (`local_damping`): 1/2 dv M dv of the grains, and by contact what its law gives
/// on its way - the energy of its press, the trapezoid of its springs and dashpot - less what its impulse gives. The
/// end's share of the trapezoid is booked by `end_step`.
ConeEnd solve_step(const Model& model, State& state, double dt, const ConeSettings& asked, Team& team, Room& room) {
  Grains& g = state.grains;
  ConeSystem& system = room.system;
  const Vec3 fall = dt * model.motion.gravity;
  std::vector<ConeContact>& contacts = system.contact;
  room.impulse.resize(contacts.size());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ConeContact& c = contacts[k];
    for (std::size_t j = 0; j < cone_rows; ++j) room.impulse[k][j] = dt * system.held[k].held[j];
    if (c.b != ConeContact::fixed || fall.isZero(0)) continue;  // two that fall do not meet faster
    const ConeRows added = along(c, -fall);
    for (std::size_t j = 0; j < spin_row; ++j) c.free[j] += added[j], system.held[k].moved[j] += added[j];
  }
  const ConeEnd end = room.solver.solve(system.body, contacts, asked, room.impulse, team);
  if (!found(state, end)) return end;
  const auto& change = room.solver.changes(system.body, contacts, room.impulse, team);
  double lost = 0, work = 0;
  room.pressed = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ConeContact& c = contacts[k];
    const HeldContact& of = system.held[k];
    const ConeRows &impulse = room.impulse[k], by = room.solver.moved(c);
    ConeRows velocity = of.moved;
    double given = 0;
    for (std::size_t j = 0; j < cone_rows; ++j) velocity[j] += by[j], given += impulse[j] * velocity[j];
    lost += of.energy - given;
    if (impulse[press_row] > 0) lost += half_work(of, velocity, dt);
    work -= global(c, impulse).dot(of.driven);
    room.pressed += impulse[press_row] / dt;
  }
  take_changes(g, change, fall, dt, g.force, g.torque, lost, work);
  room.lost = lost;
  state.ledger.work += work;
  return end;
}

/// Rows of the next step, and what they say of this one. Returns how far the forces that the laws say are from those
/// that were taken, over the contacts' forces; of a step that makes energy of nothing that it is of no use.
double end_step(const Model& model, State& state, double dt, Team& team, Room& room) {
  fill(model, state, dt, team, room.system);
  double held = 0;
  for (const HeldContact& of : room.system.held)
    room.lost += half_work(of, of.moved, dt) - of.energy, held += of.energy;
  state.ledger.damping += room.lost, state.ledger.local_damping += room.lost;
  if (room.lost < -made * held) return INFINITY;
  double off = 0;
  for (std::size_t i = 0; i < state.grains.size(); ++i) off += (state.grains.force[i] - 0.5 * room.taken[i]).norm();
  return room.pressed > 0 ? 0.5 * off / room.pressed : 0;
}

[[noreturn]] void refuse_step(const Model& model, const State& s, std::size_t contacts, const ConeEnd& end) {
  throw Unstable(fmt::format(
      "implicit step of {:.3g} s: the forces of {} contacts are not found in {} iterations (residual "
      "{:.2g}, asked {:g}; off from what overlaps say {:.2g}, asked {:g}), at t = {:.6g} s: lower numerics.{}",
      s.dt, contacts, end.iterations, end.residual, settings.tolerance, end.by_overlap, settings.by_overlap, s.time,
      model.numerics.time_step > 0 ? "time_step" : "max_time_step"));
}

std::uint64_t run(const Model& model, State& state, std::uint64_t count, Team& team) {
  Grains& g = state.grains;
  const MotionSettings free = solved_motion(model, state);
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
  const bool chosen = model.numerics.time_step == 0;
  const auto too_long = [&] { state.watch = StepWatch::firmer, state.next_estimate = state.steps; };
  fill(model, state, dt, team, room.system);
  while (k < count) {
    const bool may_shrink = chosen && state.watch != StepWatch::off;
    if (may_shrink) room.before = state;
    const std::size_t contacts = room.system.contact.size();
    const ConeEnd end = solve_step(model, state, dt, accuracy_of(state, dt), team, room);
    if (!found(state, end)) {
      if (!may_shrink) refuse_step(model, state, contacts, end);
      state = room.before;
      too_long();
      break;
    }
    sweep(Kick::open, g, state.contacts, free, false, dt, state.grain_energy, team);
    double& way = state.reference.travelled;
    way += bound.of_step(k, 1.1 * take_speed(state.grain_energy), way);
    move_boundary(state.boundary, dt);
    if (const ListState found = look_at_list(g, state.boundary, state.reference); found != ListState::holds)
      renew_list(model, state, found, passes.indexes(), team);
    room.taken = g.force;
    state.next_test = state.steps + 1;  // a step gains as much load as many explicit ones
    const bool due = passes.due(state);
    for (const Pass* pass : passes)
      if (pass->before_forces) pass->before_forces(step);
    contact_forces(model.law, model.pairs, g, state.boundary, dt, true, state.contacts, team);
    sweep(Kick::close, g, state.contacts, model.motion, false, 0, state.grain_energy, team);
    const double missed = end_step(model, state, dt, team, room);
    if (may_shrink && missed > useless) {
      state = room.before, too_long();
      break;
    }
    for (const Pass* pass : passes)
      if (pass->after_forces) pass->after_forces(step);
    ++state.steps, ++k;
    state.time += dt;
    for (const Pass* pass : passes) {
      if (!due || !pass->stops || !pass->stops(step)) continue;
      finish();
      pass->conclude(step);
      if (chosen) state.next_estimate = state.steps;
      return k;
    }
    if (!chosen || state.watch == StepWatch::off) continue;
    if (missed > wrong) {
      too_long();
      break;
    }
    if (end.iterations > many || 2 * missed > wrong) state.watch = StepWatch::asked;
  }
  finish();
  return k;
}

}  // namespace

const Stepper implicit_stepper{make_ready, choose_time_step, run, true};

}  // namespace grus::dem
