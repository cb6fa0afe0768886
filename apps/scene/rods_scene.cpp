// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/rods_scene.hpp"

#include <fmt/format.h>

#include "apps/scene/packing_scene.hpp"

namespace grus::app {

dem::BondModel read_rods(Table t) {
  dem::BondModel b;
  b.criterion = dem::FaceCriterion::rod;
  if (t.has("normal_stiffness") == t.has("modulus")) t.fail("", "needs either modulus or normal_stiffness");
  b.stiffness_given = t.has("normal_stiffness");
  b.stiffness = b.stiffness_given ? t.number("normal_stiffness", dimension::foundation, positive)
                                  : t.number("modulus", dimension::pressure, positive);
  b.ratio = t.number_or("shear_ratio", 0.4, dimension::none, {0, 1, true});
  b.tension = t.number("tension", dimension::pressure, positive);
  b.cohesion = t.number("shear", dimension::pressure, positive);
  b.tan_phi = std::tan(t.number_or("friction_angle", 0, dimension::angle, {0, 0.49 * dem::pi}));
  b.radius_ratio = t.number_or("radius_ratio", b.radius_ratio, dimension::none, {0, 2, true});
  b.gap = t.number_or("gap", b.gap, dimension::none, {0, 1});
  b.damping = t.number_or("damping", 0, dimension::none, {0, 1, false, true});
  b.weibull = t.number_or("weibull", 0, dimension::none, {1, 1000});
  for (const char* key : {"poissons_ratio", "criterion", "cohesion", "fracture_energy", "shear_energy", "between",
                          "length", "strain", "rotation"})
    if (t.has(key))
      t.fail(key,
             "is of bonds of faces (contact = \"overlap\"); those of spheres are parallel bonds, with tension, "
             "shear and shear_ratio");
  t.finish();
  return b;
}

void refuse_rods(Table& material, const dem::Material& m, const std::string& contact) {
  if (contact == "jkr")
    material.fail("bond", "cannot be with contact = \"jkr\": one of them holds the spheres together");
  if (m.fracture) material.fail("bond", "cannot be with fracture: bonded spheres do not break themselves");
  if (!m.turns) material.fail("bond", "needs spheres that turn: leave out rotation = false");
}

bool read_round(Table& t, const RveScene& scene) {
  if (!t.flag_or("round", false)) return false;
  if (scene.recipe.bounds != dem::Bounds::open) t.fail("round", "is for samples without [boundary]");
  check_cylinder(t, scene.recipe.box);
  return true;
}

dem::Agglomerates read_agglomerates(Table& t, RveScene& scene, std::uint8_t material) {
  if (t.choice_or("grains", "clusters", {"one", "clusters"}) == "one")
    t.fail("grains", "\"one\" has no parents; leave them out, or ask for \"clusters\"");
  if (!scene.recipe.box.isZero()) t.fail("box", "is that of packing.parents");
  if (scene.scale != 1) t.fail("parents", "loading.scale is for grains of one piece");
  dem::Agglomerates grains;
  grains.radius = read_radius(t);
  if (t.has("solid_fraction")) grains.solid_fraction = t.number("solid_fraction", dimension::none, proper_fraction);
  if (grains.solid_fraction > 0.7) t.fail("solid_fraction", "is at most 0.7 for spheres that fill a body");
  grains.material = material, grains.place = t.place("radius");
  check_mass(t, scene.model.materials[material], grains.radius.mean, "radius");
  RveScene parents;
  parents.file = scene.file, parents.model = scene.model, parents.recipe.bounds = scene.recipe.bounds;
  Table of_parents = t.table("parents");
  if (of_parents.has("material")) of_parents.fail("material", "has no effect here: the pieces have packing.material");
  read_packing(std::move(of_parents), parents);
  if (auto* random = std::get_if<dem::RandomPacking>(&parents.recipe.grains);
      random && !random->hulls && random->parts.size() == 1 && random->parts[0].aspect == dem::Vec3::Ones())
    grains.parents = std::move(*random);
  else if (auto* spheres = std::get_if<dem::Spheres>(&parents.recipe.grains))
    grains.parents = std::move(*spheres);
  else if (const auto* lattice = std::get_if<dem::Lattice>(&parents.recipe.grains))
    grains.parents = *lattice;
  else
    t.fail("parents", "are spheres alone");
  scene.model.seed = parents.model.seed;
  scene.recipe.box = parents.recipe.box;
  dem::Recipe counted = parents.recipe;
  counted.grains = grains;
  if (!(counted.count() < 5e6)) t.fail("radius", "more than five million spheres; check both radii");
  return grains;
}

}  // namespace grus::app
