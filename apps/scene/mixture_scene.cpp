// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/mixture_scene.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scene/packing_scene.hpp"
#include "dem/state/order.hpp"

namespace grus::app {
namespace {

using Part = PendingPacking::Part;

bool shaped(const Part& part) { return part.aspect.minCoeff() != part.aspect.maxCoeff(); }

/// Longest half axis of an ellipsoid over the radius of a sphere of its volume.
double reach_of(const Part& part) { return part.aspect.maxCoeff() / std::cbrt(part.aspect.prod()); }

/// Grain i's part is entry i, and again from the first: who has had least of his share is next.
std::vector<std::size_t> deal(const std::vector<Part>& parts) {
  double all = 0;
  for (const Part& part : parts) all += part.share;
  std::vector<double> had(parts.size(), 0.0);
  std::vector<std::size_t> row(parts.size() == 1 ? 1 : 10000);
  for (std::size_t i = 0; i < row.size(); ++i) {
    std::size_t next = 0;
    double most = -1;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const double lacks = parts[k].share / all * static_cast<double>(i + 1) - had[k];
      if (lacks > most) most = lacks, next = k;
    }
    had[next] += 1, row[i] = next;
  }
  return row;
}

Part read_part(Table t, const RveScene& scene, dem::Container container) {
  Part part;
  part.material = material_of(t, scene.model, t.text("material"));
  part.share = t.number("share", dimension::none, positive);
  part.aspect = read_aspect(t);
  t.finish();
  if (!shaped(part)) return part;
  const dem::Material& material = scene.model.materials[part.material];
  if (container == dem::Container::cylinder) t.fail("aspect", "a cylinder needs a scene of spheres alone");
  if (!material.turns)
    t.fail("aspect", fmt::format("material.{}.rotation = false needs a scene of spheres alone", material.name));
  if (material.balls()) t.fail("aspect", "no spheres: \"apollonian-14\" splits spheres");
  return part;
}

}  // namespace

std::vector<Part> read_parts(Table& t, const RveScene& scene, dem::Container container, std::uint8_t material) {
  std::vector<Part> parts;
  for (Table& part : t.tables("mixture")) parts.push_back(read_part(part, scene, container));
  if (parts.empty()) return {Part{material}};
  for (const char* other : {"material", "hulls"})
    if (t.has(other)) t.fail(other, "packing.mixture says what its grains are");
  return parts;
}

std::vector<double> reaches(const std::vector<Part>& parts) {
  std::vector<double> reach;
  if (std::any_of(parts.begin(), parts.end(), shaped))
    for (const std::size_t k : deal(parts)) reach.push_back(reach_of(parts[k]));
  return reach;
}

void put_grains(const dem::Packing& packing, const std::vector<Part>& parts, bool turned, RveScene& scene) {
  scene.packing_overlap = packing.worst_overlap;
  const std::vector<std::size_t> row = deal(parts);
  for (std::size_t i = 0; i < packing.spheres.size(); ++i) {
    const Part& part = parts[row[i % row.size()]];
    const dem::Material& material = scene.model.materials[part.material];
    dem::GrainSpec spec;
    const double radius = packing.spheres[i].radius / reach_of(part);
    spec.shape = dem::PolyEllipsoid::sphere(radius);
    if (shaped(part)) spec.shape.plus = spec.shape.minus = radius / std::cbrt(part.aspect.prod()) * part.aspect;
    spec.position = packing.spheres[i].position;
    spec.material = part.material;
    spec.density = material.density;
    spec.turns = material.turns;
    spec.inertia = scene.model.numerics.inertia_factor(radius);
    if (turned) spec.orientation = dem::random_rotation(scene.model.seed, i);
    dem::set_grain(scene.state.grains, i, spec);
  }
  dem::sort_in_space(scene.state.grains);
}

}  // namespace grus::app
