// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/voronoi_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scene/bodies_scene.hpp"
#include "apps/scene/packing_scene.hpp"

namespace grus::app {
namespace {

using dem::Vec3;

constexpr double most_voronoi = 5e5;

/// As the table asks for it.
double wanted_count(Table& t, double volume) {
  if (t.has("cells") == t.has("cell_size")) t.fail("", "needs either cells or cell_size");
  if (t.has("cells")) return static_cast<double>(t.integer_or("cells", 1, 1, static_cast<long>(most_voronoi)));
  return std::round(volume / std::pow(t.number("cell_size", dimension::length, positive), 3));
}

/// Over a convex polygon of the plane; moved so that its bounds begin at the origin.
dem::TessellationSpace read_prism_outline(Table& t, Vec3& box) {
  const auto given = t.points("corners", dimension::length);
  const double height = t.number("height", dimension::length, positive);
  t.finish();
  if (given.size() < 3 || given.size() > 32) t.fail("corners", "3 to 32 corners are needed");
  std::vector<Vec3> corners;
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (const auto& c : given) {
    if (c[2] != 0) t.fail("corners", "are points [x, y, 0] of the plane");
    corners.emplace_back(c[0], c[1], 0);
    low = low.cwiseMin(corners.back()), high = high.cwiseMax(corners.back());
  }
  for (Vec3& c : corners) c -= low;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec3 &a = corners[k], &b = corners[(k + 1) % corners.size()], &c = corners[(k + 2) % corners.size()];
    if (!((b - a).cross(c - b).z() > 1e-9 * (high - low).squaredNorm()))
      t.fail("corners", "are those of a convex polygon, counter-clockwise");
  }
  box = high - low + Vec3(0, 0, height);
  return dem::prism_space(corners, height);
}

/// What it takes of space.
Vec3 read_cylinder(Table& t) {
  const double diameter = t.number("diameter", dimension::length, positive);
  const double length = t.number("length", dimension::length, positive);
  t.finish();
  return {diameter, diameter, length};
}

dem::TessellationSpace read_ellipsoid_outline(Table& packing, Table& t, Vec3& box) {
  const auto axes = t.numbers("semi_axes", 6, dimension::length);
  t.finish();
  if (!(*std::min_element(axes.begin(), axes.end()) > 0)) t.fail("semi_axes", "all six must be above 0");
  const dem::PolyEllipsoid shape{{axes[0], axes[2], axes[4]}, {axes[1], axes[3], axes[5]}};
  box = shape.plus + shape.minus;
  return dem::polyellipsoid_space(shape, wanted_count(packing, dem::volume(shape)));
}

dem::TessellationSpace read_space(Table& t, bool periodic, Vec3& box) {
  for (const char* outline : {"cylinder", "prism", "polyellipsoid"}) {
    if (!t.has(outline)) continue;
    if (!box.isZero()) t.fail(outline, fmt::format("Voronoi cells fill either a box or a {}", outline));
    if (periodic) t.fail(outline, "a periodic cell is a box");
    box.setConstant(NAN);  // until it is found
  }
  if (auto c = t.table_if("cylinder")) {
    box = read_cylinder(*c);
    return dem::cylinder_space(box.x(), box.z());
  }
  if (auto p = t.table_if("prism")) return read_prism_outline(*p, box);
  if (auto e = t.table_if("polyellipsoid")) return read_ellipsoid_outline(t, *e, box);
  if (box.isZero()) t.fail("", "box, cylinder, prism or polyellipsoid is missing");
  return periodic ? dem::periodic_space(box) : dem::box_space(box);
}

std::size_t read_count(Table& t, const dem::TessellationSpace& space, const Vec3& box, std::size_t seeds) {
  for (const char* key : {"cells", "cell_size"})
    if (seeds > 0 && t.has(key)) t.fail(key, "the seeds are as many as their file has: leave it out");
  if (seeds > 0) return seeds;
  double count = wanted_count(t, space.volume());
  if (t.has("cell_size")) {
    const double size = t.number("cell_size", dimension::length, {0, box.minCoeff(), true});
    if (space.extruded) count = std::round(space.volume() / (size * size * box.z()));
  }
  if (!(count <= most_voronoi)) t.fail("cell_size", "more than half a million Voronoi cells; check box and cell_size");
  return std::max<std::size_t>(1, static_cast<std::size_t>(count));
}

std::vector<Vec3> read_seeds(Table& t) {
  try {
    return read_points(t.path("seeds"), read_unit(t));
  } catch (const InputError& e) {
    t.fail("seeds", e.what());
  }
}

/// Grains of a packing of its own, each filled with Voronoi cells.
void read_filled(Table& t, RveScene& scene, std::uint8_t material) {
  if (t.choice_or("grains", "clusters", {"one", "clusters"}) == "one")
    t.fail("grains", "\"one\" has no parents; leave them out, or ask for \"clusters\"");
  if (!scene.recipe.box.isZero()) t.fail("box", "is that of packing.parents");
  dem::FilledGrains filled;
  filled.count = static_cast<std::size_t>(t.integer_or("cells", 20, 1, 10000));
  filled.rounds = static_cast<int>(t.integer_or("relax", 5, 0, 1000));
  filled.material = material, filled.place = t.place("cells");
  RveScene parents;
  parents.file = scene.file, parents.model = scene.model;
  if (scene.recipe.periodic()) parents.recipe.bounds = dem::Bounds::periodic;
  Table of_parents = t.table("parents");
  if (of_parents.has("material")) of_parents.fail("material", "has no effect here: the pieces have packing.material");
  read_packing(std::move(of_parents), parents);
  if (parents.recipe.of_voronoi()) t.fail("parents", "are spheres or poly-ellipsoids");
  if (parents.recipe.count() * static_cast<double>(filled.count) > most_voronoi)
    t.fail("cells", "more than half a million Voronoi cells");
  scene.model.seed = parents.model.seed;
  scene.recipe.box = parents.recipe.box;
  if (auto* random = std::get_if<dem::RandomPacking>(&parents.recipe.grains)) filled.parents = std::move(*random);
  if (const auto* lattice = std::get_if<dem::Lattice>(&parents.recipe.grains)) filled.parents = *lattice;
  if (auto* spheres = std::get_if<dem::Spheres>(&parents.recipe.grains)) filled.parents = std::move(*spheres);
  scene.recipe.grains = std::move(filled);
}

}  // namespace

void read_voronoi(Table& t, RveScene& scene, std::uint8_t material) {
  const bool periodic = scene.recipe.periodic();
  if (t.has("parents")) return read_filled(t, scene, material);
  Vec3& box = scene.recipe.box;
  dem::VoronoiPacking cells;
  cells.space = read_space(t, periodic, box);
  cells.space->extruded = t.flag_or("extruded", false);
  cells.round = t.has("cylinder");
  if (t.has("seeds")) cells.seeds = read_seeds(t);
  cells.count = read_count(t, *cells.space, box, cells.seeds.size());
  const double count = static_cast<double>(cells.count);
  const char* counted_by = cells.seeds.empty() ? "cells" : "seeds";
  if (periodic) {
    const double side = cells.space->extruded ? std::sqrt(box.x() * box.y() / count) : std::cbrt(box.prod() / count);
    for (int k = 0; k < (cells.space->extruded ? 2 : 3); ++k)
      if (box[k] < 3.99 * side)
        t.fail("box", fmt::format("a periodic box needs four Voronoi cells a side; {} make {:.2g} along {}",
                                  cells.count, box[k] / side, "xyz"[k]));
  }
  cells.rounds = static_cast<int>(t.integer_or("relax", cells.seeds.empty() ? 5 : 0, 0, 1000));
  check_mass(t, scene.model.materials[material], std::cbrt(cells.space->volume() / count) / 2, counted_by);
  if (t.choice_or("grains", "one", {"one", "clusters"}) == "clusters")
    cells.clusters = static_cast<std::size_t>(t.integer_or("clusters", 2, 2, static_cast<long>(cells.count)));
  cells.material = material, cells.place = t.place(counted_by);
  scene.recipe.grains = std::move(cells);
}

void read_prisms(Table& t, RveScene& scene, std::uint8_t material) {
  Vec3& box = scene.recipe.box;
  if (scene.recipe.periodic()) t.fail("kind", "prisms are not for a periodic cell");
  auto cylinder = t.table_if("cylinder");
  if (cylinder && !box.isZero()) t.fail("cylinder", "prisms fill either a box or a cylinder");
  if (cylinder) box = read_cylinder(*cylinder);
  if (box.isZero()) t.fail("", "box or cylinder is missing");
  dem::Prisms prisms;
  prisms.side = t.number("side", dimension::length, positive);
  prisms.thickness = t.number("thickness", dimension::length, positive);
  prisms.gap = t.number_or("gap", 0, dimension::length, {0, 0.5 * prisms.side, false, true});
  const double each = prisms.side * prisms.side * prisms.thickness;
  if (!(box.prod() / each < most_voronoi)) t.fail("side", "more than some hundred thousand prisms");
  check_mass(t, scene.model.materials[material], std::cbrt(each) / 2, "side");
  prisms.round = cylinder.has_value(), prisms.material = material, prisms.place = t.place("side");
  scene.recipe.grains = std::move(prisms);
}

}  // namespace grus::app
