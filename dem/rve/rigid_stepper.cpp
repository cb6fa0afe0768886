// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/rigid_stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dem/base/error.hpp"
#include "dem/contact/deepest_contact.hpp"
#include "dem/contact/forces.hpp"
#include "dem/contact/hull_pairs.hpp"
#include "dem/contact/way_bound.hpp"
#include "dem/rve/cone_steps.hpp"
#include "dem/rve/renew_list.hpp"
#include "dem/rve/rigid_rows.hpp"

namespace grus::dem {
namespace {

constexpr ConeSettings settings{.tolerance = 1e-5, .by_overlap = 1, .iterations = 4000};
constexpr ConeSettings of_places{.tolerance = 1e-3, .by_overlap = 1, .iterations = 300};
constexpr int rounds = 8;             // in which parting by sliding is taken back where that has no end
constexpr double flight = 0.01;       // in a step, of the mean radius
constexpr double longest = 1;         // s, where nothing moves and nothing pulls
constexpr std::uint64_t between = 5;  // steps between looks at the step
constexpr double undone = 0.5;        // in a step, of what points are too deep
constexpr double too_deep = 0.5;      // of the overlap that contacts keep, beyond which that is looked at
constexpr double yielding = 0.02;     // of places alone, over what a contact's two bodies give: what is jammed stays

/// Energies are judged against what all grains gain by falling for a step at least: what bears them is found to a share
/// of their weight, whose work in samples at rest is all the work there is.
void note_fall(const Model& model, State& state) {
  const double fall = state.dt * model.motion.gravity.norm();
  state.ledger.floor = std::max(state.ledger.floor, 0.5 * total_mass(state.grains) * fall * fall);
}

/// The step in which what is fastest goes its flight, or falls it from rest.
void choose_time_step(const Model& model, State& state, Team&) {
  if (state.steps < state.next_estimate) return;
  const Numerics& n = model.numerics;
  state.next_estimate = state.steps + between, state.estimate_interval = between;
  if (n.time_step > 0) {
    state.dt = n.time_step, state.next_estimate = std::numeric_limits<std::uint64_t>::max();
    note_fall(model, state);
    return;
  }
  double fastest = 0;
  for (const Motion& m : state.grains.motion) fastest = std::max(fastest, m.velocity.norm() + m.spin.norm() * m.radius);
  for (const Wall& wall : state.boundary.walls) fastest = std::max(fastest, wall.velocity.norm());
  const double way = flight * state.mean_radius, pull = model.motion.gravity.norm();
  state.dt = n.max_time_step > 0 ? n.max_time_step : longest;
  if (fastest > 0) state.dt = std::min(state.dt, way / fastest);
  if (pull > 0) state.dt = std::min(state.dt, std::sqrt(2 * way / pull));
  note_fall(model, state);
}

/// Contacts hold no energy and no spring: where the search begins is the force that they show.
void drop_springs(Contacts& c) {
  for (std::size_t k = 0; k < c.size(); ++k) {
    Contact now = c.contact[k];
    now.spring[slide_spring].setZero(), now.compliance = now.viscous = 0;
    c.contact.set(k, now), c.touch[k].held = 0;
  }
}

void make_ready(const Model& model, State& state, Team& team) {
  explicit_stepper.prepare(model, state, team);
  drop_springs(state.contacts);
  state.ledger.start = kinetic_energy(state.grains);  // what springs held is of the preparation
  state.next_estimate = state.steps;
  choose_time_step(model, state, team);
}

/// Room of a run.
struct Room {
  ConeSolver solver;
  RigidSystem system;
  std::vector<ConeRows> impulse, press;
  std::vector<ConeContact> parting;  // rows of places, and of rounds
  std::vector<double> slip;          // m/s, by row: what the last round has taken parting back by
  std::vector<ConeSolver::Change> shift;
  std::vector<Vec3> taken, turned;  // N, N m: twice the mean force and torque on each grain in the step
};

/// The force that a pair shows is shared by its points.
void begin_search(const State& state, double dt, Room& room) {
  const auto& points = room.system.point;
  room.impulse.resize(points.size());
  for (std::size_t first = 0, end = 0; first < points.size(); first = end) {
    while (end < points.size() && points[end].pair == points[first].pair) ++end;
    const Vec3 share = dt / static_cast<double>(end - first) * state.contacts.touch[points[first].pair].force;
    for (std::size_t r = first; r < end; ++r) room.impulse[r] = along(room.system.contact[r], share);
  }
}

/// Norm of what all grains bring along and fall by (N s): impulses that are far less are none.
double momentum_of(const Grains& g, const Vec3& fall) {
  double sum = 0;
  for (std::size_t i = 0; i < g.size(); ++i)
    sum += g.mass[i] * g.mass[i] * (g.motion[i].velocity.squaredNorm() + fall.squaredNorm());
  return std::sqrt(sum);
}

[[noreturn]] void refuse_step(const Model& model, const State& s, std::size_t points, const ConeEnd& end) {
  throw Unstable(
      fmt::format("rigid step of {:.3g} s: the forces of {} points are not found in {} iterations (residual {:.2g}, "
                  "asked {:g}), at "
                  "t = {:.6g} s: grains that do not give way are driven where they cannot go, or lower numerics.{}",
                  s.dt, points, end.iterations, end.residual, settings.tolerance, s.time,
                  model.numerics.time_step > 0 ? "time_step" : "max_time_step"));
}

/// Impulses where the solver finds none: what slides may touch in turn, or part, with the parting by friction x slip
/// that it takes back on the way, and neither lasts. With that parting the problem is convex and has an answer; it is
/// taken back by half of what is left in each of some rounds. What is left then lifts the few contacts that go on so.
ConeEnd solve_in_rounds(const ConeSettings& once, Team& team, Room& room) {
  const RigidSystem& system = room.system;
  ConeSettings asked = once;
  asked.parts = true;
  room.slip.assign(system.contact.size(), 0.0);
  std::fill(room.impulse.begin(), room.impulse.end(), ConeRows{});
  ConeEnd end;
  for (int round = 0; round < rounds; ++round) {
    room.parting = system.contact;
    for (std::size_t r = 0; r < room.parting.size(); ++r)
      room.parting[r].free[press_row] += room.parting[r].friction * room.slip[r];
    end = room.solver.solve(system.body, room.parting, asked, room.impulse, team);
    if (!end.found(asked)) break;
    room.solver.changes(system.body, system.contact, room.impulse, team);
    for (std::size_t r = 0; r < room.slip.size(); ++r) {
      const ConeContact& c = system.contact[r];
      const ConeRows by = room.solver.moved(c);
      const double now = room.impulse[r][press_row] > 0 ? std::hypot(c.free[1] + by[1], c.free[2] + by[2]) : 0;
      room.slip[r] += 0.5 * (now - room.slip[r]);
    }
  }
  return end;
}

/// Impulses of the step to come, as forces that the sweep takes for half a step.
/// Booked are friction, impulse x slip; work of the boundary and of gravity; and what blows and the scheme lose, 1/2 dv
/// M dv and what points press while they close (`local_damping`: none of it has a law).
void solve_step(const Model& model, State& state, double dt, Team& team, Room& room) {
  Grains& g = state.grains;
  RigidSystem& system = room.system;
  begin_search(state, dt, room);
  ConeSettings asked = settings;
  asked.least = momentum_of(g, dt * model.motion.gravity);
  ConeEnd end = room.solver.solve(system.body, system.contact, asked, room.impulse, team);
  if (!end.found(asked)) end = solve_in_rounds(asked, team, room);
  if (!end.found(asked)) refuse_step(model, state, system.contact.size(), end);
  const auto& change = room.solver.changes(system.body, system.contact, room.impulse, team);
  const Vec3 fall = dt * model.motion.gravity;
  double lost = 0, rubbed = 0, work = 0;
  for (std::size_t r = 0; r < system.contact.size(); ++r) {
    const ConeContact& c = system.contact[r];
    const ConeRows &impulse = room.impulse[r], by = room.solver.moved(c);
    ConeRows& now = system.point[r].moved;  // as it is at the end of the step
    for (std::size_t j = 0; j < spin_row; ++j) now[j] += by[j];
    lost -= impulse[press_row] * now[press_row];
    rubbed -= impulse[1] * now[1] + impulse[2] * now[2];
    work -= global(c, impulse).dot(system.point[r].driven);
  }
  take_changes(g, change, fall, dt, room.taken, room.turned, lost, work);
  Ledger& l = state.ledger;
  l.damping += lost, l.local_damping += lost, l.friction += rubbed, l.work += work;
}

/// How far grains are to be moved apart: the least that undoes a part of what points will be too deep, as velocities
/// that last a step (room.shift). They are of places alone, so pushing out makes no energy. False: none is too deep.
bool part(const State& state, double dt, Team& team, Room& room) {
  const RigidSystem& system = room.system;
  const Contacts& contacts = state.contacts;
  bool deep = false;
  room.parting = system.contact, room.press.assign(system.contact.size(), {});
  for (std::size_t r = 0; r < system.contact.size(); ++r) {
    const RigidPoint& of = system.point[r];
    ConeContact& c = room.parting[r];
    const bool walled = of.pair >= contacts.begin[first_wall];
    const double radius = smaller_radius(state.grains, contacts.pair[of.pair], walled);
    deep = deep || of.gap < -too_deep * kept_overlap * radius;
    c.friction = c.slip = 0, c.free = {};
    c.free[press_row] = of.moved[press_row] + (of.gap < 0 ? undone : 1) * of.gap / dt;
    c.compliance[press_row] = yielding * (system.body[c.a].inverse_mass + (walled ? 0 : system.body[c.b].inverse_mass));
  }
  if (!deep) return false;
  room.solver.solve(system.body, room.parting, of_places, room.press, team);
  room.shift = room.solver.changes(system.body, room.parting, room.press, team);
  return true;
}

/// Moves grains by what `part` has found; returns the furthest way (m). What gravity does on it is booked as work, and
/// as the scheme's: speeds stay.
double shift(const Model& model, State& state, double dt, const Room& room) {
  Grains& g = state.grains;
  double furthest = 0, work = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    const Vec3 way = dt * room.shift[i].velocity, turn = dt * room.shift[i].spin;
    const Quat by = rotation_by(turn);
    Motion& m = g.motion[i];
    m.position += way, m.spin = by * m.spin;
    g.orientation[i] = unit(by * g.orientation[i]), g.angular_momentum[i] = by * g.angular_momentum[i];
    work += g.mass[i] * model.motion.gravity.dot(way);
    furthest = std::max(furthest, way.norm() + turn.norm() * m.radius);
  }
  update_frames(g);
  Ledger& l = state.ledger;
  l.work += work, l.damping += work, l.local_damping += work;
  l.most_damping += std::min(work, 0.0);  // what was lifted is no sign of a fault
  return furthest;
}

/// Contacts show what the step has found: those that bear touch, at the place that bears their force.
void show(const Model& model, State& state, double dt, const Room& room) {
  Contacts& contacts = state.contacts;
  const auto& points = room.system.point;
  std::size_t r = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    Touch& touch = contacts.touch[k];
    Vec3 force = Vec3::Zero();
    double press = 0, deepest = 0, width = 0;
    const std::size_t first = r;
    for (; r < points.size() && points[r].pair == k; ++r) {
      const Vec3 impulse = global(room.system.contact[r], room.impulse[r]);
      force += impulse / dt, press += room.impulse[r][press_row];
      deepest = std::max(deepest, -points[r].gap);
      width = std::max(width, (points[r].at - points[first].at).norm());
    }
    Contact c = contacts.contact[k];
    touch.force = force, touch.overlap = deepest, touch.held = 0;
    if (press > 0) {
      const Pair& p = contacts.pair[k];
      const bool walled = k >= contacts.begin[first_wall];
      const PairLaw& law = model.pairs[p.law];
      c.radius = walled ? foundation_of(law, state.grains, p.a) : foundation_of(law, state.grains, p.a, p.b);
      c.stiffness = c.radius * std::max(width * width, kept_overlap * state.grains.extent[p.a].volume /
                                                           state.grains.extent[p.a].equivalent_radius);
    } else {
      c = {};
    }
    contacts.contact.set(k, c), contacts.active[k] = press > 0;
  }
}

std::uint64_t run(const Model& model, State& state, std::uint64_t count, Team& team) {
  Grains& g = state.grains;
  const MotionSettings free = solved_motion(model, state);
  const double dt = state.dt;
  WayBound bound(g, free.affine, dt);
  Room room;
  for (std::uint64_t k = 0; k < count; ++k) {
    fill(model, state, dt, team, room.system);
    solve_step(model, state, dt, team, room);
    show(model, state, dt, room);
    const bool parts = part(state, dt, team, room);
    g.force = room.taken, g.torque = room.turned;
    sweep(Kick::open, g, state.contacts, free, false, dt, state.grain_energy, team);
    double& way = state.reference.travelled;
    way += bound.of_step(k, 1.1 * take_speed(state.grain_energy), way);
    if (parts) way += shift(model, state, dt, room);
    move_boundary(state.boundary, dt);
    sweep(Kick::close, g, state.contacts, free, false, 0, state.grain_energy, team);
    for (std::size_t i = 0; i < g.size(); ++i) g.force[i] = 0.5 * room.taken[i], g.torque[i] = 0.5 * room.turned[i];
    if (const ListState found = look_at_list(g, state.boundary, state.reference); found != ListState::holds)
      renew_list(model, state, found, false, team);
    ++state.steps, state.time += dt;
    state.ledger.most_work = std::max(state.ledger.most_work, std::abs(state.ledger.work));
    state.ledger.most_friction = std::max(state.ledger.most_friction, state.ledger.friction);
    state.ledger.most_damping = std::max(state.ledger.most_damping, state.ledger.damping);
  }
  for (auto& e : state.grain_energy) e = {.speed2 = e.speed2};
  state.grain_steps += count * g.size();
  if (state.contacts.index.first.empty()) index_grains(g.size(), state.contacts, state.reference.room.next);
  return count;
}

}  // namespace

const Stepper rigid_stepper{make_ready, choose_time_step, run, true};

}  // namespace grus::dem
