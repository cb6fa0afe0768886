// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/compaction.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"
#include "dem/sample/walls.hpp"

namespace grus::dem {
namespace {

/// Grains are brought closer by this part of all lengths, and then moved apart by it.
constexpr double margin = 1e-3;

/// Overlap, over the smaller radius, that may be left before that. Corners of hulls that meet by so little press by
/// next to nothing, and part the more slowly.
constexpr double at_rest = 0.5 * margin, at_rest_of_hulls = 5 * margin;
constexpr double too_deep = 0.06;  // at which grains first push each other away

constexpr double long_way = 4e-3, short_way = 5e-4;  // of all lengths, while nothing jams and later
constexpr double near = 0.85;                        // of the solid fraction that is asked for
constexpr std::uint64_t push = 30;                   // steps: some periods of the stiffest contact
constexpr int patience = 500;                        // of such rounds
constexpr double way_back = 1e-3;                    // of all lengths, where they have jammed
constexpr double told_less = 1;  // hundredths: what was had by way of too much is not always had by way of less

/// No friction, no weight, nothing that breaks: contacts alone, damped.
Model slippery(Model model) {
  for (Material& m : model.materials) {
    m.fracture.reset(), m.bond.reset();
    m.friction = m.rolling_friction = 0, m.restitution = 0.2;
  }
  model.motion.gravity.setZero();
  model.numerics = {};
  model.numerics.max_energy_error = model.numerics.max_overlap.emplace(INFINITY);
  model.stepper = &explicit_stepper;
  make_pair_laws(model);
  set_damping(model, 0.5);
  return model;
}

class Compaction {
public:
  Compaction(const Model& own, const Recipe& recipe, const Vec3& larger, Grains& grains, Team& team)
      : model_(slippery(own)), team_(team) {
    Recipe bounds;
    bounds.bounds = recipe.bounds, bounds.box = larger, bounds.wall_material = recipe.wall_material;
    if (recipe.periodic()) state_.boundary.cell.vectors = Mat3(larger.asDiagonal());
    put_bounds(bounds, state_.boundary);
    state_.grains = std::move(grains);
  }

  double fraction() const { return 1 / (1 + void_ratio(state_)); }

  /// All lengths, by a factor; grains keep their sizes.
  void stretch(double factor) {
    for (Motion& m : state_.grains.motion) m.position *= factor;
    for (Wall& wall : state_.boundary.walls) wall.point *= factor;
    state_.boundary.cell.vectors *= factor;
  }

  /// Overlap that is left, over the smaller radius, once grains have pushed each other away for long enough.
  double separate(double enough, const std::function<void()>& told) {
    double deepest = INFINITY;
    for (int round = 0; round < patience && deepest > enough; ++round) {
      told();
      rest_uphill();
      prepare(model_, state_, team_);
      for (const std::uint64_t end = state_.steps + push; state_.steps < end;) {
        update_time_step(model_, state_, team_);
        run_steps(model_, state_, std::min(end, state_.next_estimate) - state_.steps, team_);
      }
      deepest = deepest_contact(state_.grains, state_.contacts).ratio;
    }
    return deepest;
  }

  double overlap() {
    prepare(model_, state_, team_);
    return deepest_contact(state_.grains, state_.contacts).ratio;
  }

  Grains take() {
    Grains& g = state_.grains;
    const Vec3 edges = state_.boundary.cell.vectors.diagonal();
    for (std::size_t i = 0; i < g.size(); ++i) {
      Motion& m = g.motion[i];
      m.velocity.setZero(), m.spin.setZero(), g.angular_momentum[i].setZero();
      g.force[i].setZero(), g.torque[i].setZero();
      for (int k = 0; k < 3; ++k)
        if (edges[k] > 0) m.position[k] -= edges[k] * std::floor(m.position[k] / edges[k]);
    }
    return std::move(g);
  }

private:
  /// Who goes against what pushes him stops: the others gather speed, so that weak corners part as well.
  void rest_uphill() {
    Grains& g = state_.grains;
    for (std::size_t i = 0; i < g.size(); ++i) {
      Motion& m = g.motion[i];
      if (!(g.force[i].dot(m.velocity) > 0)) m.velocity.setZero();
      if (!(g.torque[i].dot(m.spin) > 0)) m.spin.setZero(), g.angular_momentum[i].setZero();
    }
  }

  Model model_;
  State state_;
  Team& team_;
};

}  // namespace

void compact(const Model& model, const Recipe& recipe, const Vec3& larger, Grains& grains, double& overlap, Team& team,
             const Watch& watch) {
  for (const Motion& m : grains.motion)
    if (2 * m.radius >= recipe.box.minCoeff())
      throw InputError(fmt::format("a grain of radius {:.3g} m does not fit the box", m.radius));
  Compaction c(model, recipe, larger, grains, team);
  const double begin = c.fraction(), closest = recipe.box[0] / larger[0] * (1 - margin);
  const double asked = begin * std::pow(recipe.box[0] / larger[0], -3);
  double size = 1;
  const auto told = [&] { tell(watch, std::min(0.999, std::log(size) / std::log(closest)), "the sample was packed"); };
  const auto go_to = [&](double next) { c.stretch(next / size), size = next; };
  while (size > closest) {
    const double way = c.fraction() < near * asked ? long_way : short_way;
    go_to(std::max(closest, size * (1 - way)));
    if (c.separate(too_deep, told) > too_deep) break;
  }
  bool jammed = size > closest;
  const double enough = recipe.of_hulls() ? at_rest_of_hulls : at_rest;
  while (c.separate(enough, told) > enough) jammed = true, go_to(size * (1 + way_back));
  go_to(size / (1 - margin));
  if (jammed)
    throw InputError(fmt::format(
        "{:g}: the densest random packing found of these grains in this box is {:.2f}; ask for no more and compress "
        "the sample, or use a larger box",
        asked, std::floor(100 * c.fraction() - told_less) / 100));
  overlap = std::max(0.0, c.overlap());
  grains = c.take();
}

}  // namespace grus::dem
