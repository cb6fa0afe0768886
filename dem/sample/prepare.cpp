// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/prepare.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/rve/step.hpp"
#include "dem/sample/density.hpp"

namespace grus::dem {
namespace {

/// The model while a sample is compressed: explicit steps, which know no held one of a test that solves its contacts;
/// the friction of `materials`, and enough damping to come to rest.
Model compressing(Model model) {
  if (model.stepper->long_steps) model.numerics.time_step = 0;
  model.stepper = &explicit_stepper;
  renew_friction(model);
  if (std::all_of(model.damping.begin(), model.damping.end(), [](double d) { return d == 0; })) set_damping(model, 0.3);
  return model;
}

/// Compresses the state; what fails tells where the pressure was asked for.
void bring_to(const Vec3& stresses, const Model& model, const Preparation& p, State& state, Team& team,
              const StageWatch& watch) {
  try {
    compress(model, p.quasi_static, state, stresses, team, stage_of(watch, "preparation"));
  } catch (const Unstable& e) {
    throw Unstable((p.place_of_pressure.empty() ? "preparation" : p.place_of_pressure) + ": " + e.what());
  }
}

/// Radius (m) of the smallest grain there may be, and how much flatter than a sphere one is.
struct Smallest {
  double radius = INFINITY, slenderness = 1;
};

Smallest smallest_of(const Listed& grains) {
  Smallest all;
  for (const ListedGrain& g : grains) {
    const PolyEllipsoid& shape = g.spec.shape;
    const double radius = equivalent_radius(shape);
    all.radius = std::min(all.radius, radius);
    all.slenderness = std::max(all.slenderness, 2 * radius / (shape.plus + shape.minus).minCoeff());
  }
  return all;
}
Smallest smallest_of(const RandomPacking& p) {
  Smallest all{p.radius.kind == "constant" ? p.radius.mean : p.radius.min};
  for (const Part& part : p.parts)
    all.slenderness = std::max(all.slenderness, part.aspect.maxCoeff() / part.aspect.minCoeff());
  return all;
}
Smallest smallest_of(const Lattice& l) { return {l.radius}; }
Smallest smallest_of(const Spheres& s) {
  Smallest all;
  for (const Sphere& sphere : s.spheres) all.radius = std::min(all.radius, sphere.radius);
  return all;
}
template <class Cells>
Smallest smallest_of(const Cells&) {
  return {};
}

}  // namespace

Watch stage_of(const StageWatch& watch, const char* what) {
  return watch ? Watch([&watch, what](double done) { return watch(done, what); }) : Watch();
}

State compressed(State state, const Model& own, const std::optional<Preparation>& preparation, Team& team,
                 const StageWatch& watch, FoundDensity* found) {
  if (!preparation) return state;
  if (preparation->void_ratio) {
    FoundDensity unasked;
    return compressed_to_density(state, own, *preparation, team, watch, found ? *found : unasked);
  }
  Model model = own;  // the friction of the preparation, not of the test
  for (auto& m : model.materials)
    if (std::isfinite(m.youngs_modulus)) m.friction = preparation->friction;
  model = compressing(std::move(model));
  std::vector<Vec3> own_way;  // of the sides, in the test
  for (const Wall& wall : state.boundary.walls) own_way.push_back(wall.velocity);
  prepare(model, state, team);
  bring_to(Vec3::Constant(preparation->pressure), model, *preparation, state, team, watch);
  for (std::size_t w = 0; w < own_way.size(); ++w) state.boundary.walls[w].velocity = own_way[w];
  return state;
}

State start_from(State state, const Model& own, const std::optional<Preparation>& preparation, Team& team,
                 const StageWatch& watch, const std::optional<Vec3>& stresses) {
  if (preparation) {
    if (stresses) {
      const Model model = compressing(own);
      prepare(model, state, team);
      bring_to(*stresses, model, *preparation, state, team, watch);
    }
    state.time = 0;
    state.steps = 0;
    state.ledger = {};
    state.grain_steps = 0;
  }
  prepare(own, state, team);
  return state;
}

State make_ready(const Model& model, const Recipe& recipe, Team& team, const StageWatch& watch) {
  State state = make(model, recipe, team, stage_of(watch, "packing")).state;
  state = compressed(std::move(state), model, recipe.preparation, team, watch);
  return start_from(std::move(state), model, recipe.preparation, team, watch);
}

std::string unbearable(const Model& model, const Recipe& recipe, double pressure) {
  if (recipe.of_hulls()) return {};
  const Smallest smallest = std::visit([](const auto& grains) { return smallest_of(grains); }, recipe.grains);
  const double slender = smallest.slenderness, limit = model.overlap_limit();
  const double most = slender * slender * unbearable_pressure(model, smallest.radius);
  if (!(pressure > most)) return {};
  return fmt::format(
      "{:.3g} MPa is too high for this contact stiffness: at {:.2g} MPa grains of any packing {}; lower the pressure, "
      "or make the material stiffer",
      pressure / 1e6, most / 1e6,
      limit < 0.5 ? fmt::format("overlap by more than {:.0f} % of a radius (numerics.max_overlap)", 100 * limit)
                  : "have filled all voids");
}

}  // namespace grus::dem
