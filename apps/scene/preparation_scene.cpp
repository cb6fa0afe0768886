// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/preparation_scene.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace grus::app {
namespace {

/// Radius of the smallest grain there may be (m).
double smallest_radius(const RveScene& scene) {
  if (scene.pending)
    return scene.pending->radius.kind == "constant" ? scene.pending->radius.mean : scene.pending->radius.min;
  double smallest = INFINITY;
  for (const dem::Extent& e : scene.state.grains.extent) smallest = std::min(smallest, e.equivalent_radius);
  return smallest;
}

/// Of ellipsoids, whose flat sides are stiffer than a sphere of their volume; 1 of spheres.
double slenderness(const RveScene& scene) {
  double most = 1;
  for (const dem::Extent& e : scene.state.grains.extent) most = std::max(most, 2 * e.equivalent_radius / e.least_width);
  if (scene.pending)
    for (const auto& part : scene.pending->parts)
      most = std::max(most, part.aspect.maxCoeff() / part.aspect.minCoeff());
  return most;
}

}  // namespace

std::string unbearable(const RveScene& scene, double pressure) {
  if (scene.of_hulls()) return {};
  const double slender = slenderness(scene), limit = scene.model.overlap_limit();
  const double most = slender * slender * dem::unbearable_pressure(scene.model, smallest_radius(scene));
  if (!(pressure > most)) return {};
  return fmt::format(
      "{:.3g} MPa is too high for this contact stiffness: at {:.2g} MPa grains of any packing {}; lower the pressure, "
      "or make the material stiffer",
      pressure / 1e6, most / 1e6,
      limit < 0.5 ? fmt::format("overlap by more than {:.0f} % of a radius (numerics.max_overlap)", 100 * limit)
                  : "have filled all voids");
}

void read_preparation(Table& t, RveScene& scene) {
  auto p = t.table_if("preparation");
  if (!p) return;
  if (!scene.state.boundary.cell.periodic()) t.fail("preparation", "needs boundary.kind = \"periodic\"");
  Preparation prep;
  prep.pressure = p->number("pressure", dimension::pressure, positive);
  prep.friction = p->number_or("friction", scene.model.materials.front().friction, dimension::none, not_negative);
  prep.quasi_static = read_quasi_static(*p);
  p->finish();
  if (const std::string fault = unbearable(scene, prep.pressure); !fault.empty()) p->fail("pressure", fault);
  scene.preparation = prep;
}

}  // namespace grus::app
