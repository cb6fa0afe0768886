// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/recipe.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/packing/prisms.hpp"

namespace grus::dem {
namespace {

double count_of(const Listed& grains, const Recipe&) { return static_cast<double>(grains.size()); }
double count_of(const RandomPacking& p, const Recipe& recipe) {
  if (p.count > 0) return static_cast<double>(p.count);
  const double volume = volume_of(container_of(recipe.bounds, p.round), recipe.box);
  return p.solid_fraction * volume / (4 * pi / 3 * p.radius.mean_cube());
}
double count_of(const Lattice& l, const Recipe&) {
  return static_cast<double>(l.layers[0]) * static_cast<double>(l.layers[1]) * static_cast<double>(l.layers[2]);
}
double count_of(const Spheres& s, const Recipe&) { return static_cast<double>(s.spheres.size()); }
double count_of(const VoronoiPacking& t, const Recipe&) { return static_cast<double>(t.count); }
double count_of(const Prisms& p, const Recipe& recipe) {
  return static_cast<double>(prisms_of(p, recipe.box).seed.size());
}
double count_of(const Bodies& b, const Recipe&) { return static_cast<double>(b.body.size()); }
double solid_of(const RandomPacking& p, const Recipe& recipe) {
  return count_of(p, recipe) * 4 * pi / 3 * p.radius.mean_cube();
}
double solid_of(const Lattice& l, const Recipe& recipe) {
  return count_of(l, recipe) * 4 * pi / 3 * l.radius * l.radius * l.radius;
}
double solid_of(const Spheres& s, const Recipe&) {
  double sum = 0;
  for (const Sphere& sphere : s.spheres) sum += 4 * pi / 3 * sphere.radius * sphere.radius * sphere.radius;
  return sum;
}
/// As if none were cut by the surface of its grain, where fewer find room.
double count_of(const Agglomerates& a, const Recipe& recipe) {
  const double solid = std::visit([&](const auto& p) { return solid_of(p, recipe); }, a.parents);
  return a.solid_fraction * solid / (4 * pi / 3 * a.radius.mean_cube());
}
double count_of(const FilledGrains& f, const Recipe& recipe) {
  return static_cast<double>(f.count) * std::visit([&](const auto& p) { return count_of(p, recipe); }, f.parents);
}

}  // namespace

bool Recipe::of_voronoi() const { return voronoi_material(*this) != nullptr; }

bool Recipe::of_hulls() const {
  if (const auto* p = std::get_if<RandomPacking>(&grains)) return p->hulls.has_value();
  if (const Listed* l = listed()) return std::any_of(l->begin(), l->end(), [](const auto& g) { return g.hull(); });
  return of_voronoi();
}

bool Recipe::in_cylinder() const {
  return bounds == Bounds::cylinder || std::any_of(walls.begin(), walls.end(), [](const OwnWall& w) {
           return std::holds_alternative<CylinderWall>(w.wall.shape);
         });
}

Container container_of(Bounds bounds, bool round) {
  if (bounds == Bounds::periodic) return Container::periodic;
  if (bounds == Bounds::periodic_xy) return Container::periodic_xy;
  return bounds == Bounds::cylinder || round ? Container::cylinder : Container::box;
}

bool Recipe::at_mesh() const {
  return std::any_of(walls.begin(), walls.end(), [](const OwnWall& w) { return w.wall.mesh() != nullptr; });
}

double Recipe::count() const {
  return std::visit([&](const auto& g) { return count_of(g, *this); }, grains);
}

const std::uint8_t* voronoi_material(const Recipe& recipe) {
  if (const auto* t = std::get_if<VoronoiPacking>(&recipe.grains)) return &t->material;
  if (const auto* p = std::get_if<Prisms>(&recipe.grains)) return &p->material;
  if (const auto* f = std::get_if<FilledGrains>(&recipe.grains)) return &f->material;
  if (const auto* b = std::get_if<Bodies>(&recipe.grains)) return b->materials.data();
  return nullptr;
}

bool is_round(const Recipe& recipe) {
  const auto* t = std::get_if<VoronoiPacking>(&recipe.grains);
  const auto* p = std::get_if<Prisms>(&recipe.grains);
  const auto* b = std::get_if<Bodies>(&recipe.grains);
  const auto* random = std::get_if<RandomPacking>(&recipe.grains);
  const auto* spheres = std::get_if<Spheres>(&recipe.grains);
  return (t && t->round) || (p && p->round) || (b && b->round) || (random && random->round) ||
         (spheres && spheres->round);
}

Vec3 box_of(const Lattice& l, bool periodic) {
  const double r = l.radius;
  if (periodic && l.hexagonal)
    return {2 * r * l.layers[0], std::sqrt(3.0) * r * l.layers[1], std::sqrt(8.0 / 3) * r * l.layers[2]};
  return (l.hexagonal ? hexagonal_close(r, l.layers) : simple_cubic(r, l.layers)).box;
}

Tessellation prisms_of(const Prisms& p, const Vec3& box) {
  try {
    return hexagonal_prisms(box, p.side, p.thickness, p.gap, p.round);
  } catch (const InputError& e) {
    refuse(p.place, e.what());
  }
}

Vec3 voronoi_box(const Recipe& recipe) {
  const auto* p = std::get_if<Prisms>(&recipe.grains);
  if (!p || p->round) return recipe.box;
  Vec3 taken = Vec3::Zero();
  for (const Polyhedron& body : prisms_of(*p, recipe.box).body)
    for (const Vec3& v : body.vertex) taken = taken.cwiseMax(v);
  return taken;
}

std::optional<Recipe> piece_of(const Recipe& recipe) {
  constexpr double enough = 1000;
  const double all = recipe.random() ? recipe.count() : 0;
  if (recipe.bounds == Bounds::open || all <= 1.5 * enough) return {};
  Recipe piece = recipe;
  auto& p = std::get<RandomPacking>(piece.grains);
  const double scale = std::max(std::cbrt(enough / all), 3 * p.radius.mean / recipe.box.minCoeff());
  if (scale >= 1) return {};
  piece.box *= scale, p.count = 0;
  piece.rough.clear();  // which might take all of it
  return piece;
}

std::string unthinkable_mass(const Material& material, double radius) {
  const double mass = material.density * 4 * pi / 3 * radius * radius * radius, inertia = mass * radius * radius;
  if (mass > 1e-290 && inertia > 1e-290 && inertia < 1e290 && mass < 1e290) return {};
  return fmt::format("a grain of radius {:.3g} m and density {:.3g} kg/m^3 has a mass of {:.3g} kg: out of all bounds",
                     radius, material.density, mass);
}

void refuse(const Place& place, const std::string& why) { throw InputError(place.empty() ? why : place + ": " + why); }

}  // namespace grus::dem
