// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/preparation_scene.hpp"

#include "dem/sample/prepare.hpp"

namespace grus::app {
namespace {

/// The void ratio that the preparation is to leave, told as it is or between two.
void read_density(Table& t, dem::Preparation& prep) {
  const bool relative = t.has("relative_density");
  if (t.has("void_ratio")) {
    if (relative) t.fail("relative_density", "cannot be beside void_ratio: give one");
    prep.void_ratio = t.number("void_ratio", dimension::none, positive), prep.place_of_density = t.place("void_ratio");
  }
  if (!relative) return;
  const double loosest = t.number("void_ratio_max", dimension::none, positive);
  const double densest = t.number("void_ratio_min", dimension::none, {0, loosest, true, true});
  prep.void_ratio = loosest - t.number("relative_density", dimension::none, {0, 1}) * (loosest - densest);
  prep.place_of_density = t.place("relative_density");
}

}  // namespace

void read_preparation(Table& t, RveScene& scene) {
  auto p = t.table_if("preparation");
  if (!p) return;
  if (!scene.recipe.periodic() && scene.recipe.bounds != dem::Bounds::walls)
    t.fail("preparation", "needs boundary.kind = \"periodic\" or \"walls\"");
  if (scene.recipe.supports.glue) t.fail("preparation", "cannot be with boundary.bonded: the walls hold the grains");
  if (!scene.recipe.rough.empty())
    t.fail("preparation", "cannot be with fixed_layer or fixed_material: give a first [[stage]] that compresses");
  dem::Preparation prep;
  prep.pressure = p->number("pressure", dimension::pressure, positive), prep.place_of_pressure = p->place("pressure");
  prep.friction = p->number_or("friction", scene.model.materials.front().friction, dimension::none, not_negative);
  read_density(*p, prep);
  prep.quasi_static = read_quasi_static(*p);
  p->finish();
  if (const std::string fault = dem::unbearable(scene.model, scene.recipe, prep.pressure); !fault.empty())
    p->fail("pressure", fault);
  scene.recipe.preparation = prep;
}

}  // namespace grus::app
