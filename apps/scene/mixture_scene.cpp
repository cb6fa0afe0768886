// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/mixture_scene.hpp"

#include <fmt/format.h>

#include "apps/scene/packing_scene.hpp"

namespace grus::app {
namespace {

using dem::Part;

Part read_part(Table t, const RveScene& scene) {
  Part part;
  part.material = material_of(t, scene.model, t.text("material"));
  part.share = t.number("share", dimension::none, positive);
  part.aspect = read_aspect(t);
  t.finish();
  if (part.aspect.minCoeff() == part.aspect.maxCoeff()) return part;
  const dem::Material& material = scene.model.materials[part.material];
  if (scene.recipe.bounds == dem::Bounds::cylinder) t.fail("aspect", "a cylinder needs a scene of spheres alone");
  if (!material.turns)
    t.fail("aspect", fmt::format("material.{}.rotation = false needs a scene of spheres alone", material.name));
  if (material.balls()) t.fail("aspect", "no spheres: \"apollonian-14\" splits spheres");
  return part;
}

}  // namespace

std::vector<Part> read_parts(Table& t, const RveScene& scene, std::uint8_t material) {
  std::vector<Part> parts;
  for (Table& part : t.tables("mixture")) parts.push_back(read_part(part, scene));
  if (parts.empty()) return {Part{material}};
  for (const char* other : {"material", "hulls"})
    if (t.has(other)) t.fail(other, "packing.mixture says what its grains are: leave one of the two out");
  return parts;
}

}  // namespace grus::app
