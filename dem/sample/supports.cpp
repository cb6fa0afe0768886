// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/supports.hpp"

#include <fmt/format.h>

#include "dem/rve/hand_over.hpp"

namespace grus::dem {
namespace {

constexpr double least_stiffer = 0.02;  // a mesh differs by as much from another

std::vector<OuterFace> end_of(const Sample& sample, const Vec3& outward, const Place& place, double& offset) {
  auto faces = faces_towards(sample.faces->outer, outward, offset);
  if (faces.empty()) refuse(place, "the Voronoi cells have no flat end there");
  return faces;
}

void put_clamp(const Model& model, const Clamp& clamp, Sample& sample) {
  double offset = 0;
  const auto faces = end_of(sample, clamp.outward, clamp.place, offset);
  auto& walls = sample.state.boundary.walls;
  const std::size_t at = walls.size();
  Wall wall;
  wall.point = offset * clamp.outward, wall.shape = PlaneWall{-clamp.outward};
  wall.velocity = clamp.velocity, wall.material = clamp.material;
  walls.push_back(wall);
  glue(model, faces, static_cast<Index>(at), clamp.slides, sample.state);
  double area = 0;
  for (const auto& f : faces) area += f.face.area;
  if (!wall.velocity.isZero(0))  // the force along its way that it meets
    sample.gauge = Gauge{{{at, -1.0}}, wall.velocity.normalized(), at, 1 / area};
}

}  // namespace

void glue_to_walls(const Model& model, const Glue& how, const Recipe& recipe, Sample& sample) {
  const auto& walls = sample.state.boundary.walls;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    const Vec3 outward = -walls[w].facing();
    double offset = 0;
    const auto faces = faces_towards(sample.faces->outer, outward, offset);
    const double gap = walls[w].point.dot(outward) - offset;
    if (faces.empty() || std::abs(gap) > 1e-6 * voronoi_box(recipe).maxCoeff())
      refuse(how.place, fmt::format("no Voronoi cell touches the wall {}", walls[w].name));
    glue(model, faces, static_cast<Index>(w), how.slides, sample.state);
  }
}

void put_supports(const Model& model, const Supports& supports, Sample& sample) {
  for (const Clamp& clamp : supports.clamps) put_clamp(model, clamp, sample);
  for (const EndLoad& load : supports.loads) {
    double offset = 0;
    const auto faces = end_of(sample, load.outward, load.place, offset);
    add_load(faces, load.force, load.ramp, sample.state);
  }
  if (supports.clamps.empty()) return;
  int axis = 0;
  sample.state.boundary.walls.front().facing().cwiseAbs().maxCoeff(&axis);
  note_stiffness(model, axis, sample);
}

void note_stiffness(const Model& model, int axis, Sample& sample) {
  const auto& bond = model.materials[sample.state.grains.material[0]].bond;
  const bool network = bond && sample.faces->bonds > 0 && fragments_of(sample.state).size.size() == 1;
  const double more = network ? stiffer_than_endless(sample.state, *bond, axis) - 1 : 0;
  if (std::abs(more) < least_stiffer) return;
  sample.notes.push_back(fmt::format(
      "along {} these Voronoi cells are some {:.0f} % {} than bond.modulus, which is that of many cells: next to a "
      "plane face they "
      "line up with it (docs/bonded.md); take more cells, or calibrate modulus with these",
      "xyz"[axis], 100 * std::abs(more), more > 0 ? "stiffer" : "softer"));
}

}  // namespace grus::dem
