// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/preparation_scene.hpp"

#include "dem/sample/prepare.hpp"

namespace grus::app {

void read_preparation(Table& t, RveScene& scene) {
  auto p = t.table_if("preparation");
  if (!p) return;
  if (!scene.recipe.periodic()) t.fail("preparation", "needs boundary.kind = \"periodic\"");
  dem::Preparation prep;
  prep.pressure = p->number("pressure", dimension::pressure, positive);
  prep.friction = p->number_or("friction", scene.model.materials.front().friction, dimension::none, not_negative);
  prep.quasi_static = read_quasi_static(*p);
  p->finish();
  if (const std::string fault = dem::unbearable(scene.model, scene.recipe, prep.pressure); !fault.empty())
    p->fail("pressure", fault);
  scene.recipe.preparation = prep;
}

}  // namespace grus::app
