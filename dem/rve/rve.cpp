// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/rve.hpp"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>

#include "dem/base/clock.hpp"
#include "dem/base/error.hpp"
#include "dem/base/parallel.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/real_time.hpp"
#include "dem/rve/resting.hpp"
#include "dem/rve/steady.hpp"
#include "dem/rve/step.hpp"

namespace grus::dem {
namespace {

/// What the inertial number goes by; without a floor a cell that is drawn goes by its tension.
double pressure_of(const QuasiStatic& o, const State& s) {
  const double p = mean_pressure(love_weber(s, s.boundary.cell.volume()));
  return std::max({o.pressure_floor > 0 ? p : std::abs(p), o.pressure_floor, 1e-9});
}

/// More steps than any increment takes: the cell has no stress that tells how fast it may be strained.
constexpr double endless = 1e8;
constexpr std::uint64_t patience = 20000;  // steps in which stress may yet grow

}  // namespace

Response hold(const Model& model, const QuasiStatic& o, State& state, Team& team, const std::function<void()>& told) {
  Response response;
  const std::uint64_t first = state.steps;
  Mat3 before = love_weber(state, bulk_volume(state.boundary));
  while (true) {
    const std::size_t broken = state.ledger.breakages;
    if (told) told();
    update_time_step(model, state, team);
    run_steps(model, state, static_cast<std::uint64_t>(o.window), team);
    const Measurement m = measure(model, state);
    const double scale = std::max({m.stress.norm(), std::sqrt(3.0) * o.pressure_floor, 1e-9});
    response.stress = m.stress;
    response.unbalanced_force = m.unbalanced_force;
    response.stress_change = (m.stress - before).norm() / scale;
    before = m.stress;
    response.hold_steps = state.steps - first;
    // A stress far below the floor is no contact network: its forces need not balance better than the floor's.
    const double relevance = std::min(1.0, m.stress.norm() / scale);
    if (m.unbalanced_force * relevance <= o.unbalanced_force && response.stress_change <= o.stress_change &&
        state.ledger.breakages == broken) {
      response.stable = true;
      return response;
    }
    if (response.hold_steps >= o.max_hold) {
      response.failure = fmt::format(
          "not in equilibrium after {} steps: unbalanced force {:.2g} (asked {:.2g}), stress change {:.2g} "
          "(asked {:.2g})",
          response.hold_steps, m.unbalanced_force, o.unbalanced_force, response.stress_change, o.stress_change);
      return response;
    }
  }
}

void add_tangent(const Model& model, const State& state, Response& response) {
  const Clock clock;
  response.tangent = contact_stiffness_tangent(model, state);
  response.tangent_seconds += clock.wall();
}

Response deform(const Model& model, const QuasiStatic& o, State& state, const Increment& increment, Team& team,
                const std::function<void()>& told) {
  Mat3 r, u;
  polar(increment.deformation, r, u);
  if ((r - Mat3::Identity()).norm() < 1e-15) r.setIdentity();
  const std::uint64_t first = state.steps;
  const std::size_t broken = state.ledger.breakages;
  Cell& cell = state.boundary.cell;
  const Mat3 start = cell.began(), target = u * start;
  double strain = (u - Mat3::Identity()).norm();
  if (strain < 1e-14) strain = 0;  // a rotation, to round-off
  double done = 0;
  while (done < 1 && strain > 0) {
    if (told) told();
    update_time_step(model, state, team);
    // Rate from the target inertial number: I = rate d sqrt(rho / p).
    const double per_rate = inertial_number(state, 1, pressure_of(o, state));
    const double step = std::min(o.strain_per_step, o.inertial_number / std::max(per_rate, 1e-300) * state.dt);
    const double to_go = std::ceil(std::max(1.0, strain * (1 - done) / step));
    if (to_go > endless && state.steps - first > patience)
      throw Unstable(
          "the cell holds next to no stress, by which it would be strained for ever: give pressure_floor (Pa), or load "
          "it first");
    const auto remaining = static_cast<std::uint64_t>(std::min(to_go, 1e18));
    const std::uint64_t chunk = std::min({remaining, std::uint64_t{100}, state.next_estimate - state.steps});
    const double piece = (1 - done) * static_cast<double>(chunk) / static_cast<double>(remaining);
    set_cell_rate(state, cell.of_began((target - start) * (piece / (static_cast<double>(chunk) * state.dt))));
    const std::uint64_t ran = run_steps(model, state, chunk, team);
    done = ran == remaining ? 1 : done + piece * static_cast<double>(ran) / static_cast<double>(chunk);
  }
  cell.vectors = cell.of_began(target);  // differs by round-off only
  set_cell_rate(state, Mat3::Zero());
  Response response = hold(model, o, state, team, told);
  check_sanity(model, state);
  if (!r.isIdentity(0)) {
    rotate(state, r);
    response.stress = love_weber(state, cell.volume());
  }
  response.steps = state.steps - first;
  response.breakages = state.ledger.breakages - broken;
  add_tangent(model, state, response);
  return response;
}

Response deform_in_pieces(const Model& model, const QuasiStatic& o, State& state, const Increment& increment,
                          int pieces, Team& team, const std::function<void()>& told) {
  if (pieces == 1) return deform(model, o, state, increment, team, told);
  Mat3 r, u;
  polar(increment.deformation, r, u);
  const std::uint64_t first = state.steps;
  const std::size_t broken = state.ledger.breakages;
  Response response;
  Mat3 before = Mat3::Identity();
  for (int k = 1; k <= pieces; ++k) {
    const Mat3 now = Mat3::Identity() + (u - Mat3::Identity()) * (static_cast<double>(k) / pieces);
    response = deform(model, o, state, {now * before.inverse()}, team, told);
    before = now;
    if (!response.stable) break;
  }
  if (response.stable && !r.isIdentity(1e-15)) {
    rotate(state, r);
    response.stress = love_weber(state, state.boundary.cell.volume());
    add_tangent(model, state, response);
  }
  response.steps = state.steps - first;
  response.breakages = state.ledger.breakages - broken;
  return response;
}

namespace {

/// No increment gets there: grains shrunk by half the overlap that they may have do not overlap any more, and still
/// fill more than the cell.
bool leaves_no_room(const Model& model, const State& s, double volume_ratio) {
  double slender = 1;
  for (const Extent& e : s.grains.extent) slender = std::max(slender, 2 * e.equivalent_radius / e.least_width);
  const double shrunk = 1 - 0.5 * model.overlap_limit() * slender;
  return shrunk > 0 && shrunk * shrunk * shrunk * solid_volume(s.grains) > volume_ratio * s.boundary.cell.volume();
}

/// Why a cell cannot follow an increment, whatever its grains do; empty: it may. An absurd one would take its
/// steps for ever.
std::string refusal(const Model& model, const State& s, const Mat3& f) {
  const double ratio = f.determinant();
  if (!f.allFinite() || !(ratio > 0))
    return fmt::format("det F = {:.4g}; an increment is finite, with det F > 0", ratio);
  if (leaves_no_room(model, s, ratio))
    return fmt::format(
        "an increment to {:.3g} of the volume leaves no room for the grains, were they to overlap by {:.0f} % of a "
        "radius everywhere (numerics.max_overlap): take a smaller one",
        ratio, 100 * model.overlap_limit());
  const Vec3 stretch = Eigen::JacobiSVD<Mat3>(f).singularValues();  // falling
  if (!(stretch[0] <= Rve::most_stretch && stretch[2] >= 1 / Rve::most_stretch))
    return fmt::format(
        "an increment that stretches by {:.4g} to {:.4g}; one may stretch by {:g} to {:g}: take a smaller one",
        stretch[2], stretch[0], 1 / Rve::most_stretch, Rve::most_stretch);
  return {};
}

}  // namespace

Rve::Rve(std::shared_ptr<const Model> model, QuasiStatic options, State state, const Steady& steady)
    : model_(std::move(model)), options_(options), committed_(std::move(state)), steady_(steady) {}

Response Rve::advance(const Increment& increment, State& trial, const std::function<void()>& told) {
  Team team(1);
  fresh_ = false;
  Response response;
  committed_ = at_rest(std::move(committed_));
  wake(trial);
  response.failure = refusal(*model_, trial, increment.deformation);
  if (!response.failure.empty()) return response;
  std::uint64_t spent = 0;
  for (const int pieces : {1, retry_pieces}) {
    if (pieces > 1) wake(trial);
    try {
      response = deform_in_pieces(*model_, options_, trial, increment, pieces, team, told);
    } catch (const Unstable& error) {
      response = {};
      response.failure = error.what();
    }
    spent += trial.steps - committed_.steps;
    response.pieces = pieces;
    if (response.stable) break;
  }
  response.steps = spent;
  if (response.stable) next_ = resting_copy(trial);
  fresh_ = response.stable;
  return response;
}

Response Rve::advance_in_time(const Mat3& deformation, double duration, bool tangent) {
  Team team(1);
  fresh_ = false;
  awaken(*model_, committed_, team);
  return respond_in_time(*model_, committed_, deformation, duration, tangent, team);
}

Response Rve::advance_steadily(const Mat3& deformation, bool tangent) {
  Team team(1);
  fresh_ = false;
  awaken(*model_, committed_, team);
  return respond_steadily(*model_, options_, committed_, steady_, deformation, tangent, team);
}

void Rve::wake(State& room) const {
  Team team(1);
  room = committed_;
  awaken(*model_, room, team);
}

void Rve::commit() {
  if (!fresh_) throw std::logic_error("Rve::commit without a fresh advance");
  committed_ = std::move(next_);
  fresh_ = false;
}

}  // namespace grus::dem
