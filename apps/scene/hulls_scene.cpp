// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/hulls_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scene/packing_scene.hpp"

namespace grus::app {
namespace {

using dem::Vec3;

void read_cohesive(Table& t, dem::BondModel& b) {
  b.tension = t.number("tension", dimension::pressure, positive);
  b.cohesion = t.number("cohesion", dimension::pressure, positive);
  b.tan_phi = std::tan(t.number_or("friction_angle", 0, dimension::angle, {0, 0.49 * dem::pi}));
  b.energy_1 = t.number("fracture_energy", dimension::surface_energy, positive);
  b.energy_2 = t.number_or("shear_energy", b.energy_1, dimension::surface_energy, positive);
  if (t.has("between")) b.between = t.number("between", dimension::pressure, positive);
}

void read_strain_sum(Table& t, dem::BondModel& b) {
  b.criterion = dem::FaceCriterion::strain_sum;
  b.tension = t.number("strain", dimension::none, positive);
  b.cohesion = t.number_or("rotation", INFINITY, dimension::angle, positive);
}

void read_parallel(Table& t, dem::BondModel& b) {
  b.criterion = dem::FaceCriterion::parallel;
  b.tension = t.number("tension", dimension::pressure, positive);
  b.cohesion = t.number("shear", dimension::pressure, positive);
  if (t.has("between")) b.between = t.number("between", dimension::pressure, positive);
  b.tan_phi = std::tan(t.number_or("friction_angle", 0, dimension::angle, {0, 0.49 * dem::pi}));
}

}  // namespace

dem::BondModel read_bond(Table t, double friction, std::optional<dem::Elasticity>& elasticity) {
  dem::BondModel b;
  b.friction = friction;
  if (t.has("normal_stiffness") == t.has("modulus")) t.fail("", "needs either modulus or normal_stiffness");
  if (t.has("modulus")) {
    const double modulus = t.number("modulus", dimension::pressure, positive);
    const double poisson = t.number_or("poissons_ratio", 0.2, dimension::none, {0, dem::most_poisson});
    if (t.has("shear_ratio")) t.fail("shear_ratio", "follows from poissons_ratio; or give normal_stiffness");
    elasticity = {modulus, poisson};
    const dem::Network network = dem::network_of(*elasticity);
    b.stiffness = network.stiffness, b.ratio = network.ratio;
  } else {
    b.stiffness = t.number("normal_stiffness", dimension::foundation, positive);
    b.stiffness_given = true;
    b.ratio = t.number_or("shear_ratio", 0.4, dimension::none, {0, 1, true});
  }
  if (t.has("length")) {
    if (b.stiffness_given) t.fail("length", "normal_stiffness is per area: no length is needed");
    b.length = t.number("length", dimension::length, positive);
  }
  const std::string criterion = t.choice_or("criterion", "cohesive", {"cohesive", "strain-sum", "parallel"});
  if (criterion == "cohesive") read_cohesive(t, b);
  if (criterion == "strain-sum") read_strain_sum(t, b);
  if (criterion == "parallel") read_parallel(t, b);
  b.damping = t.number_or("damping", 0, dimension::none, {0, 1, false, true});
  b.weibull = t.number_or("weibull", 0, dimension::none, {1, 1000});
  t.finish();
  return b;
}

void read_hull(Table& t, dem::ListedGrain& grain) {
  if (t.has("vertices") == t.has("box")) t.fail("", "a hull needs either vertices or box");
  if (t.has("box")) {
    grain.box = vector3(t.numbers("box", 3, dimension::length));
    if (!(grain.box.minCoeff() > 0)) t.fail("box", "all three sides must be above 0");
  } else {
    grain.vertices.emplace();
    for (const auto& p : t.points("vertices", dimension::length)) grain.vertices->emplace_back(p[0], p[1], p[2]);
  }
  grain.place = t.place("vertices"), grain.place_of_size = t.place(t.has("box") ? "box" : "vertices");
}

void check_hulls(const Table& t, const RveScene& scene) {
  const dem::Recipe& recipe = scene.recipe;
  const bool by_overlap = dem::of_hulls(scene.model.law);
  const dem::Listed* listed = recipe.listed();
  const bool mixed = listed && !std::all_of(listed->begin(), listed->end(), [](const auto& g) { return g.hull(); });
  if (!recipe.of_hulls() && !by_overlap) return;
  if (!recipe.of_hulls())
    t.fail("material",
           "contact = \"overlap\" is for hulls: packing.kind = \"voronoi\", packing.hulls, or shape = "
           "\"hull\"");
  if (mixed) t.fail("grain", "hulls meet hulls and walls alone; a scene has either hulls or other shapes");
  if (!by_overlap) t.fail("material", "hulls need contact = \"overlap\"");
  if (recipe.in_cylinder()) t.fail("boundary", "hulls cannot be in a cylinder yet; use walls or \"open\"");
  if (recipe.at_mesh()) t.fail("wall", "hulls cannot meet a wall of triangles yet; use planes");
  for (const auto& m : scene.model.materials) {
    if (m.fracture && !m.fracture->of_hulls())
      t.fail("material", fmt::format("{}.fracture: hulls are cut by model = \"cleavage\" or \"peridynamics\"", m.name));
    if (!m.turns) t.fail("material", fmt::format("{}.rotation = false is for spheres", m.name));
  }
}

}  // namespace grus::app
