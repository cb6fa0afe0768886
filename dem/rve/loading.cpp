// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/loading.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/press.hpp"
#include "dem/rve/real_time.hpp"
#include "dem/rve/rough_walls.hpp"
#include "dem/rve/servo.hpp"
#include "dem/rve/step.hpp"

namespace grus::dem {
namespace {

/// The wall at the + end of an axis, which moves; nullptr in a cell.
auto far_wall(auto& boundary, int axis) -> decltype(boundary.walls.data()) {
  for (auto& wall : boundary.walls)
    if (wall.facing()[axis] == -1) return &wall;
  return nullptr;
}

/// The first axes, so many, are those of a cell; walls carry the others.
int edges_of(const Cell& cell) { return cell.everywhere() ? 3 : cell.walled ? 2 : 0; }

}  // namespace

Vec3 size_of(const Boundary& boundary) {
  const Cell& cell = boundary.cell;
  if (cell.everywhere()) return cell.vectors.diagonal();
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  if (cell.walled) high.head<2>() = cell.vectors.diagonal().head<2>();
  for (const auto& wall : boundary.walls)
    for (int k = 0; k < 3; ++k) {
      if (wall.facing()[k] == 1) low[k] = wall.point[k];
      if (wall.facing()[k] == -1) high[k] = wall.point[k];
    }
  return high - low;
}

double axis_rate(const State& state, const Loading& loading, int axis) {
  const Cell& cell = state.boundary.cell;
  const Wall* const wall = axis < edges_of(cell) ? nullptr : far_wall(state.boundary, axis);
  return (wall ? wall->velocity[axis] : cell.rate(axis, axis)) / loading.initial_size[axis];
}

namespace {

void set_rates(State& state, const Loading& loading, const Vec3& rates) {
  const Cell& cell = state.boundary.cell;
  const int edges = edges_of(cell);
  if (edges > 0) {
    Mat3 rate = Mat3::Zero();
    for (int k = 0; k < edges; ++k) rate(k, k) = rates[k] * loading.initial_size[k];
    if (rate != cell.rate) set_cell_rate(state, rate);
  }
  for (int k = edges; k < 3; ++k)
    if (Wall* wall = far_wall(state.boundary, k)) wall->velocity[k] = rates[k] * loading.initial_size[k];
}

/// The axes without a rate grow by half of what the one that has it loses, of their present sizes.
void keep_volume(const Vec3& size, const Loading& loading, Vec3& rates) {
  int driven = 0;
  rates.cwiseAbs().maxCoeff(&driven);
  const double share = -0.5 * rates[driven] * loading.initial_size[driven] / size[driven];
  for (int k = 0; k < 3; ++k)
    if (k != driven) rates[k] = share * size[k] / loading.initial_size[k];
}

/// Sets what is kept up for the next steps, and returns how many.
std::uint64_t drive(const Model& model, State& state, const Loading& loading) {
  if (!loading.walls.empty()) {
    for (const WallControl& control : loading.walls) press_wall(model, state, control);
    return 1;
  }
  if (loading.holds && !state.boundary.cell.periodic()) {
    press_walls(model, state, loading);
    return 1;
  }
  std::uint64_t steps = 0;
  Vec3 rates = servo_rates(model, state, loading, steps);
  if (loading.isochoric) keep_volume(size_of(state.boundary), loading, rates);
  set_rates(state, loading, rates);
  return steps;
}

/// exp(A) by scaling and squaring of the series; A is an increment of a velocity gradient.
Mat3 exponential(const Mat3& a) {
  int halvings = 0;
  for (double n = a.norm(); n > 0.05; n *= 0.5) ++halvings;
  const Mat3 x = a / std::pow(2.0, halvings);
  Mat3 e = Mat3::Identity(), term = e;
  for (int k = 1; k < 12; ++k) term = term * x / k, e += term;
  for (int k = 0; k < halvings; ++k) e = e * e;
  return e;
}

}  // namespace

void begin_loading(const Model& model, State& state, Loading& loading) {
  loading.initial_size = size_of(state.boundary);
  state.servo = {.at = state.time};
  if (commands(loading)) drive(model, state, loading);
  carry_rough_walls(state);
  state.ledger.start = stored_energy(model, state);
  state.ledger.work = state.ledger.most_work = 0;
  state.grain_steps = 0;
  if (model.numerics.time_step == 0) state.next_estimate = state.steps;  // the motion may set a smaller step
}

void turn_loading(const Model& model, State& state, const Loading& loading) {
  state.servo = {.at = state.time};
  if (commands(loading)) drive(model, state, loading);
  carry_rough_walls(state);
  if (model.numerics.time_step == 0) state.next_estimate = state.steps;
}

namespace {

/// Steps, and parts of one, in which a stress that is sought cannot gain more than `left` (Pa): contacts that follow
/// the strain are as stiff as can be.
double steps_to(const Model& model, const State& state, const Loading& loading, int axis, double left) {
  double rate = 0;
  int row = axis;
  if (loading.velocity_gradient) {
    int along = 0, across = 0;
    rate = loading.velocity_gradient->cwiseAbs().maxCoeff(&along, &across);
    if (along != across) row = 6 - along - across;  // Voigt: yz, xz, xy
  } else {
    rate = std::abs(axis_rate(state, loading, axis));
  }
  const double gain = contact_stiffness_tangent(model, state)(row, row) * rate * state.dt;
  return std::min(left / gain, 1e6);
}

/// Of a step: less than this is not worth a step of its own.
constexpr double least_part = 0.05;

}  // namespace

bool endless(const State& state, double duration) {
  constexpr double most_grain_steps = 1e14;
  const double least = 1000;  // a step of few grains costs as much as one of so many
  const double grains = std::max(least, static_cast<double>(state.grains.size()));
  return !(duration / state.dt * grains < most_grain_steps);
}

bool load(const Model& model, State& state, const Loading& loading, double end, Team& team, const Watch& watch,
          const Landing& landing) {
  const double begin = state.time;
  const bool servo =
      !loading.walls.empty() || (loading.driven && (loading.isochoric || loading.first ||
                                                    std::any_of(loading.axes.begin(), loading.axes.end(),
                                                                [](const auto& a) { return a.stress.has_value(); })));
  while (true) {
    const double left = end - state.time;
    if (left <= 1e-9 * std::min(state.dt, end - begin)) break;  // steps may be far longer than what is left
    const double gap = landing.left ? landing.left(state) : INFINITY;
    if (gap <= 0) return true;  // before anything is driven anew: a run that goes on from here finds it so
    if (watch && state.time > begin && !watch((state.time - begin) / (end - begin))) return false;
    std::uint64_t corrected = 0;
    if (servo) corrected = drive(model, state, loading), carry_rough_walls(state);
    update_time_step(model, state, team);
    if (endless(state, left))
      throw Unstable(fmt::format(
          "the time step has fallen to {:.3g} s at t = {:.6g} s: {:.3g} steps to go; some grain, contact or "
          "bond has become too stiff or too light",
          state.dt, state.time, left / state.dt));
    const auto due = static_cast<std::uint64_t>(std::ceil(left / state.dt * (1 - 1e-12)));
    std::uint64_t steps = std::min<std::uint64_t>(due, state.next_estimate - state.steps);
    const bool solved = model.stepper->long_steps;
    double room = INFINITY;  // steps until a stress may be met
    if (gap < landing.near && (solved || !loading.velocity_gradient))
      room = steps_to(model, state, loading, landing.axis, gap);
    const double part = solved ? std::clamp(room, least_part, 1.0) : 1;
    if (loading.velocity_gradient) {
      if (landing.left) steps = std::min(steps, solved ? 1 : servo_steps);
      const double piece = due > steps ? static_cast<double>(steps) * state.dt : left;
      deform_in_time(model, state, exponential(*loading.velocity_gradient * (part * piece)), part * piece, team);
      continue;
    }
    if (servo) steps = std::min(steps, corrected);
    if (room < 1e6) steps = std::min(steps, static_cast<std::uint64_t>(std::max(room, 1.0)));
    const double safe = state.dt;
    if (steps == due) state.dt = left / static_cast<double>(due);  // the last steps meet the end exactly
    if (part < 1) state.dt = std::min(state.dt, part * safe);
    run_steps(model, state, steps, team);
    state.dt = safe;
  }
  state.time = end;
  return true;
}

Mat3 displacement_gradient(const State& state, const Loading& loading, const Mat3& initial_cell) {
  if (state.boundary.cell.everywhere()) return state.boundary.cell.began() * initial_cell.inverse() - Mat3::Identity();
  Mat3 h = Mat3::Zero();
  const Vec3 size = size_of(state.boundary);
  for (int k = 0; k < 3; ++k)
    if (loading.initial_size[k] > 0) h(k, k) = size[k] / loading.initial_size[k] - 1;
  return h;
}

double unbearable_pressure(const Model& model, double radius) {
  constexpr double margin = 2, neighbours = 14;
  constexpr double no_voids =
      0.5;  // of a radius: overlap of all contacts that leaves none, from the loosest packing on
  const double overlap = std::min(model.overlap_limit(), no_voids) * radius;
  double force = 0;
  for (std::size_t a = 0; a < model.materials.size(); ++a)
    for (std::size_t b = 0; b < model.materials.size(); ++b)
      if (std::isfinite(model.materials[a].youngs_modulus + model.materials[b].youngs_modulus))
        force = std::max(force, force_at(model.law, model.pairs[a * model.materials.size() + b], radius, overlap));
  return margin * neighbours * force / (4 * pi * radius * radius);  // force x radius x contacts a grain / (3 V)
}

namespace {

/// Whether compressing on would say nothing of the material is asked whenever the cell has become so much smaller.
constexpr double asked_at = 0.98;

constexpr double close_to = 0.02;  // of a stress: near enough to come to rest

/// Whether a stress has swung about what is asked so often that its rate is to be halved: strong dashpots answer the
/// rate more than the strain, and a servo that follows them never ends.
struct Swings {
  static constexpr int most = 8;
  int count = 0;
  double side = 0;

  bool operator()(double off) {
    if (std::abs(off) < close_to) return false;
    if (off * side < 0) ++count;
    side = off;
    if (count < most) return false;
    count = 0;
    return true;
  }
};

/// Throws where contacts are too deep, or `voids` that there were are gone.
void check_bearable(const Model& model, const State& state, double pressure, bool voids) {
  const double deepest = deepest_contact(state.grains, state.contacts).ratio, limit = model.overlap_limit();
  const double volume = bulk_volume(state.boundary);
  if (!(deepest > limit) && !(voids && volume < solid_volume(state.grains))) return;
  const std::string what =
      deepest > limit ? fmt::format("grains overlap by {:.0f} % of a radius (limit {:.0f} %, numerics.max_overlap)",
                                    100 * deepest, 100 * limit)
                      : "grains have filled all voids";
  throw Unstable(
      fmt::format("a pressure of {:.3g} MPa is too high for this contact stiffness: at {:.3g} MPa {}; lower the "
                  "pressure, or make the material stiffer",
                  pressure / 1e6, mean_pressure(love_weber(state, volume)) / 1e6, what));
}

}  // namespace

void stand(State& state) {
  if (state.boundary.cell.periodic()) set_cell_rate(state, Mat3::Zero());
  for (Wall& wall : state.boundary.walls) wall.velocity.setZero();
}

void compress(const Model& model, const QuasiStatic& o, State& state, const Vec3& stresses, Team& team,
              const Watch& watch) {
  const double pressure = (stresses.array() == stresses[0]).all() ? stresses[0] : stresses.mean();
  Model quiet = model;  // nothing breaks while a sample is prepared
  for (auto& m : quiet.materials) m.fracture.reset();
  quiet.numerics.max_energy_error = INFINITY;  // damped hard on purpose
  Loading loading;
  loading.driven = true;
  loading.holds = !state.boundary.cell.periodic();  // both walls of an axis press
  loading.initial_size = size_of(state.boundary);
  stand(state);
  const double rate = 5 * o.inertial_number / inertial_number(state, 1, pressure);
  for (int k = 0; k < 3; ++k) loading.axes[static_cast<std::size_t>(k)] = {0, -stresses[k], rate};
  constexpr int rounds = 4000;
  double done = 0;
  auto told = [&](double part) { tell(watch, done = std::max(done, part), "the sample was prepared"); };
  const Measurement before = measure(quiet, state);
  const double first = std::max(0.0, mean_pressure(before.stress));
  const bool voids = before.void_ratio > 0.01;
  double asked = before.volume;
  const auto bearable = [&](double) {
    const double volume = bulk_volume(state.boundary);
    if (volume < asked_at * asked) asked = volume, check_bearable(model, state, pressure, voids);
    return true;
  };
  Swings swings;
  double nearest = INFINITY;  // of all rounds: by how much a stress was off
  for (int round = 0; round < rounds; ++round) {
    load(quiet, state, loading, state.time + 100 * state.dt, team, bearable);
    const Measurement m = measure(quiet, state);
    check_bearable(model, state, pressure, voids);
    told(std::clamp((mean_pressure(m.stress) - first) / std::max(pressure - first, 1e-300), 0.0, 0.95));
    const Vec3 off = (normal_stresses(state) + stresses).array() / stresses.array();
    if (swings(off.mean()))
      for (auto& axis : loading.axes) axis.max_rate *= 0.5;
    nearest = std::min(nearest, off.cwiseAbs().maxCoeff());
    if (off.cwiseAbs().maxCoeff() < close_to && m.unbalanced_force < 5 * o.unbalanced_force) {
      stand(state);
      QuasiStatic strict = o;
      strict.pressure_floor = 0.1 * pressure;
      const Response rest = hold(quiet, strict, state, team, [&] { told(0.96); });
      if (!rest.stable) throw Unstable("the sample does not come to rest: " + rest.failure);
      const Vec3 left = (normal_stresses(state) + stresses).array() / stresses.array();
      check_bearable(model, state, pressure, voids);
      if (left.cwiseAbs().maxCoeff() < compress_tolerance) return;
    }
  }
  if (nearest < close_to)
    throw Unstable(fmt::format(
        "{:.3g} MPa is reached, but the sample does not come to rest there: grains rattle on, which half of "
        "numerics.safety (now {:g}) or a higher restitution ends",
        pressure / 1e6, quiet.numerics.safety));
  if ((stresses.array() != pressure).any())
    throw Unstable(fmt::format("stresses of {:.3g}, {:.3g}, {:.3g} Pa are not reached; start denser, or ask for less",
                               stresses.x(), stresses.y(), stresses.z()));
  throw Unstable(
      fmt::format("an isotropic pressure of {:.3g} Pa is not reached; start denser, or ask for less", pressure));
}

void compress_isotropically(const Model& model, const QuasiStatic& o, State& state, double pressure, Team& team,
                            const Watch& watch) {
  compress(model, o, state, Vec3::Constant(pressure), team, watch);
}

}  // namespace grus::dem
