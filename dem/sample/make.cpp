// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/make.hpp"

#include <fmt/format.h>

#include "dem/sample/grains.hpp"
#include "dem/sample/supports.hpp"
#include "dem/sample/walls.hpp"

namespace grus::dem {
namespace {

/// Every material that a recipe names is one of the model's.
void check_materials(const Model& model, const Recipe& recipe) {
  const auto check = [&](std::uint8_t material) {
    if (material >= model.materials.size())
      throw InputError(fmt::format("material {}: the model has {}", material, model.materials.size()));
  };
  const auto check_all = [&](const auto& grains) {
    using Kind = std::decay_t<decltype(grains)>;
    if constexpr (std::is_same_v<Kind, Listed>)
      for (const ListedGrain& g : grains) check(g.spec.material);
    else if constexpr (std::is_same_v<Kind, RandomPacking>)
      for (const Part& part : grains.parts) check(part.material);
    else if constexpr (std::is_same_v<Kind, Bodies>)
      for (const std::uint8_t material : grains.materials) check(material);
    else if constexpr (std::is_same_v<Kind, Spheres>)
      check(grains.material), std::for_each(grains.materials.begin(), grains.materials.end(), check);
    else
      check(grains.material);
  };
  std::visit(check_all, recipe.grains);
  if (const auto* filled = std::get_if<FilledGrains>(&recipe.grains)) std::visit(check_all, filled->parents);
  if (const auto* filled = std::get_if<Agglomerates>(&recipe.grains)) std::visit(check_all, filled->parents);
  for (const OwnWall& own : recipe.walls) check(own.wall.material);
  for (const Side& side : recipe.sides) check(side.material.value_or(0));
  for (const Clamp& clamp : recipe.supports.clamps) check(clamp.material);
  if (recipe.has_sides()) check(recipe.wall_material);
  if (const auto* platens = std::get_if<Platens>(&recipe.supports.press)) check(platens->material);
  if (const auto* rollers = std::get_if<Rollers>(&recipe.supports.press)) check(rollers->material);
}

/// A periodic cell and walls have a size; what holds Voronoi cells has some to hold.
void check_bounds(const Model& model, const Recipe& recipe) {
  if ((recipe.bounds != Bounds::open || recipe.random()) && !(recipe.box.minCoeff() > 0))
    throw InputError("recipe.box: all three sides must be above 0");
  const Supports& s = recipe.supports;
  const auto* cells = voronoi_material(recipe);
  const bool rollers = std::holds_alternative<Rollers>(s.press);
  if (!cells && (s.glue || !s.clamps.empty() || !s.loads.empty() || rollers))
    throw InputError("recipe.supports: only Voronoi cells can be held");
  if (cells && (s.glue || !s.clamps.empty()) && !model.materials[*cells].bond)
    throw InputError("recipe.supports: the Voronoi cells' material has no bond, by which they hold on");
}

}  // namespace

Boundary boundary_of(const Recipe& recipe) {
  Boundary boundary;
  boundary.cell = cell_of(container_of(recipe.bounds), recipe.box, 0);
  for (const OwnWall& own : recipe.walls) boundary.walls.push_back(own.wall);
  put_bounds(recipe, boundary);
  if (const auto* platens = std::get_if<Platens>(&recipe.supports.press))
    put_platens(*platens, 0, recipe.box[platens->axis], boundary);
  return boundary;
}

Sample make(const Model& model, const Recipe& recipe, Team& team, const Watch& watch) {
  check_materials(model, recipe);
  check_bounds(model, recipe);
  Sample sample;
  sample.state.boundary.cell = cell_of(container_of(recipe.bounds), recipe.box, 0);
  put_grains(model, recipe, team, watch, sample);
  double largest = 0;
  for (const Motion& m : sample.state.grains.motion) largest = std::max(largest, m.radius);
  sample.state.boundary.cell = cell_of(container_of(recipe.bounds), recipe.box, largest);
  if (sample.state.grains.size() == 0) throw InputError("the sample has no grains");
  put_own_walls(recipe, sample);
  put_bounds(recipe, sample.state.boundary);
  fix_grains(recipe, sample);
  update_frames(sample.state.grains);
  const Supports& supports = recipe.supports;
  if (supports.glue) glue_to_walls(model, *supports.glue, recipe, sample);
  put_supports(model, supports, sample);
  if (const auto* platens = std::get_if<Platens>(&supports.press)) put_platens(*platens, recipe, sample);
  if (const auto* rollers = std::get_if<Rollers>(&supports.press)) {
    put_rollers(*rollers, recipe, sample);
    note_stiffness(model, rollers->span, sample);
  }
  if (sample.faces) drop(sample.faces->outer);  // nobody else asks
  return sample;
}

Programme fitted(Programme test, const Sample& sample) {
  test.gauge = sample.gauge;
  if (test.kind != TestKind::platens) return test;
  const auto& walls = sample.state.boundary.walls;
  const double height = walls[1].point[test.axis] - walls[0].point[test.axis];
  test.strain_rate = -walls[1].velocity[test.axis] / height;
  test.duration = test.final_strain / test.strain_rate;
  return test;
}

}  // namespace grus::dem
