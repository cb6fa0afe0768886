// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/packing_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include <sstream>

#include "apps/scene/bodies_scene.hpp"
#include "apps/scene/mixture_scene.hpp"
#include "apps/scene/rods_scene.hpp"
#include "apps/scene/voronoi_scene.hpp"
#include "dem/packing/random_hulls.hpp"
#include "dem/packing/sphere_files.hpp"

namespace grus::app {
namespace {

using dem::Vec3;

/// Passing by mass against the diameter, as sieves tell it.
void read_sieve(Table& t, dem::RadiusDistribution& d) {
  for (const auto& [diameter, passing] : t.pairs("passing", dimension::length)) {
    if (!(diameter > 0)) t.fail("passing", "diameters must be above 0");
    if (!d.sieve.empty() && !(0.5 * diameter > d.sieve.back()[0] && passing >= d.sieve.back()[1]))
      t.fail("passing", "expected diameters that rise and shares of mass that do not fall");
    d.sieve.push_back({0.5 * diameter, passing});
  }
  if (d.sieve.size() < 2 || d.sieve.front()[1] != 0 || d.sieve.back()[1] != 1)
    t.fail("passing", "expected [diameter, share of mass that passes] from a share of 0 to a share of 1");
  double number = 0, sum = 0;
  for (std::size_t k = 0; k + 1 < d.sieve.size(); ++k) {
    const dem::SieveClass c = dem::sieve_class(d, k);
    number += c.number;
    sum += c.number * c.mean;
  }
  d.mean = sum / number;
  d.min = d.sieve.front()[0], d.max = d.sieve.back()[0];
}

}  // namespace

dem::RadiusDistribution read_radius(Table& packing) {
  dem::RadiusDistribution d;
  Table t = packing.table("radius");
  d.kind = t.choice("distribution", {"constant", "uniform", "truncated-normal", "log-normal", "sieve"});
  if (d.kind == "sieve") {
    read_sieve(t, d);
  } else if (d.kind == "log-normal") {
    d.median = t.number("median", dimension::length, positive);
    d.spread = t.number("spread", dimension::none, {0, 2, true});
    d.min = t.number("min", dimension::length, {0, d.median, true, true});
    d.max = t.number("max", dimension::length, {d.median, INFINITY, true});
    d.mean = std::clamp(d.median * std::exp(-2.5 * d.spread * d.spread), d.min, d.max);
  } else if (d.kind == "uniform") {
    d.min = t.number("min", dimension::length, positive);
    d.max = t.number("max", dimension::length, {d.min, INFINITY});
    d.mean = 0.5 * (d.min + d.max);
  } else {
    d.mean = t.number("mean", dimension::length, positive);
    if (d.kind == "truncated-normal") {
      d.sd = t.number("sd", dimension::length, not_negative);
      d.min = t.number("min", dimension::length, {0, d.mean, true});
      d.max = t.number("max", dimension::length, {d.mean, INFINITY});
    }
  }
  t.finish();
  return d;
}

namespace {

dem::RadiusDistribution times(dem::RadiusDistribution d, double scale) {
  for (double* length : {&d.mean, &d.sd, &d.min, &d.max, &d.median}) *length *= scale;
  for (auto& point : d.sieve) point[0] *= scale;
  return d;
}

constexpr double most_grains = 5e6;

std::optional<dem::RandomHulls> read_hulls(Table& packing) {
  auto t = packing.table_if("hulls");
  if (!t) return {};
  const bool balls = t->has("balls");
  if (balls) {
    if (const auto planes = t->integer("balls", 1, 1000); planes != dem::ball_planes)
      t->fail("balls",
              fmt::format("{}: must be 32, the planes of the roundest ball that a hull has room for (64 corners, "
                          "40 faces)",
                          planes));
  }
  if (balls && t->has("relax")) t->fail("relax", "is of angular grains; balls are what they are: leave it out");
  const int rounds = static_cast<int>(t->integer_or("relax", 5, 0, 1000));
  const Vec3 aspect = read_aspect(*t);
  t->finish();
  return dem::RandomHulls{rounds, aspect, balls};
}

}  // namespace

Vec3 read_aspect(Table& t) {
  Vec3 aspect = vector3(t.numbers_or("aspect", {1, 1, 1}, dimension::none));
  if (!(aspect.minCoeff() > 0) || !(aspect.maxCoeff() <= 10 * aspect.minCoeff()))
    t.fail("aspect", "three lengths above 0, the longest at most ten times the shortest");
  return aspect;
}

std::uint8_t material_of(Table& t, const dem::Model& model, const std::string& name, const char* key) {
  for (std::size_t i = 0; i < model.materials.size(); ++i)
    if (model.materials[i].name == name) return static_cast<std::uint8_t>(i);
  std::vector<std::string> names;
  for (const auto& m : model.materials) names.push_back(m.name);
  const std::string near = closest(name, names);
  t.fail(key, fmt::format("\"{}\": no such material{}", name,
                          near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near)));
}

/// Overlap of a radius up to which the circles of contacts are small against their grains: half the radius is then the
/// circle's.
constexpr double deepest = 0.1;

void check_mass(const Table& t, const dem::Material& material, double radius, const std::string& key) {
  if (const std::string why = dem::unthinkable_mass(material, radius); !why.empty()) t.fail(key, why);
  const auto pull = dem::attraction(material.solid(), material.contact, radius, deepest);
  if (pull && pull->told > pull->most)
    t.fail(key, fmt::format("material.{}.{} = {:.3g} {} alone would press grains of radius {:.3g} m into each other by "
                            "more than {:.0f} % of it; at most {:.3g} {}, or a stiffer material",
                            material.name, pull->name, pull->told, pull->unit, radius, 100 * deepest, pull->most,
                            pull->unit));
}

namespace {

/// How dense: a solid fraction, a void ratio, or a relative density between two of them. The key that told.
std::string read_target(Table& t, double& solid_fraction) {
  const bool by_void = t.has("void_ratio"), relative = t.has("relative_density");
  if (static_cast<int>(by_void) + static_cast<int>(relative) + static_cast<int>(t.has("solid_fraction")) > 1)
    t.fail("", "needs one of solid_fraction, void_ratio and relative_density");
  if (by_void) {
    solid_fraction = 1 / (1 + t.number("void_ratio", dimension::none, positive));
    return "void_ratio";
  }
  if (!relative) {
    solid_fraction = t.number("solid_fraction", dimension::none, proper_fraction);
    return "solid_fraction";
  }
  const double loosest = t.number("void_ratio_max", dimension::none, positive);
  const double densest = t.number("void_ratio_min", dimension::none, {0, loosest, true, true});
  const double share = t.number("relative_density", dimension::none, {0, 1});
  solid_fraction = 1 / (1 + loosest - share * (loosest - densest));
  return "relative_density";
}

dem::RandomPacking read_random(Table& t, const RveScene& scene, bool turned, std::uint8_t material) {
  dem::RandomPacking p;
  dem::Recipe of = {.bounds = scene.recipe.bounds, .box = scene.recipe.box};
  p.turned = turned;
  p.round = read_round(t, scene);
  p.parts = read_parts(t, scene, material);
  p.radius = times(read_radius(t), scene.scale);
  const std::string target = read_target(t, p.solid_fraction);
  if (p.solid_fraction > 0.74)
    t.fail(target, fmt::format("a solid fraction of {:g}: not even a lattice of spheres is denser than 0.74",
                               p.solid_fraction));
  p.count = static_cast<std::size_t>(t.integer_or("count", 0, 0, 20000000));
  of.grains = p;
  if (!(of.count() < most_grains)) t.fail("box", "more than five million grains; check box and radius");
  if (!(2 * p.radius.mean < of.box.minCoeff()))
    t.fail("box", fmt::format("a grain of the mean radius, {:.3g} m, does not fit in", p.radius.mean));
  for (const auto& part : p.parts) check_mass(t, scene.model.materials[part.material], p.radius.mean, "radius");
  p.hulls = read_hulls(t);
  p.place = t.place(target);
  return p;
}

/// hcp or simple-cubic, as many layers as are asked for or fit the box.
dem::Lattice read_lattice(Table& t, const std::string& kind, const dem::Recipe& recipe) {
  const Vec3& box = recipe.box;
  const auto radius = read_radius(t);
  if (radius.kind != "constant")
    t.fail("radius", fmt::format("distribution = \"{}\": the grains of a lattice have one radius; use \"constant\"",
                                 radius.kind));
  const double r = radius.mean;
  std::array<double, 3> asked{};
  if (t.has("layers")) {
    const auto v = t.numbers("layers", 3, dimension::none);
    for (std::size_t k = 0; k < 3; ++k) {
      asked[k] = v[k];
      if (v[k] != std::floor(v[k]) || v[k] < 1) t.fail("layers", "expected three whole numbers from 1");
    }
  } else {
    if (box.isZero()) t.fail("", "box or layers is missing");
    for (int k = 0; k < 3; ++k) asked[static_cast<std::size_t>(k)] = box[k] / (2 * r) + 1e-9;
    if (kind == "hcp") {
      asked[1] = 1 + (box[1] - 2 * r - r / std::sqrt(3.0)) / (std::sqrt(3.0) * r) + 1e-9;
      asked[0] = (box[0] / r - 1) / 2 + 1e-9;
      asked[2] = 1 + (box[2] - 2 * r) / (std::sqrt(8.0 / 3) * r) + 1e-9;
    }
  }
  for (double& n : asked) n = std::max(1.0, std::floor(n));
  if (!(asked[0] * asked[1] * asked[2] < most_grains))
    t.fail(t.has("layers") ? "layers" : "box", "more than five million grains; check box, layers and radius");
  const std::array<int, 3> layers{static_cast<int>(asked[0]), static_cast<int>(asked[1]), static_cast<int>(asked[2])};
  if (recipe.repeats() && kind == "hcp" && (layers[1] % 2 || (recipe.periodic() && layers[2] % 2)))
    t.fail("layers", recipe.periodic() ? "a periodic hcp packing needs even numbers of rows and layers"
                                       : "a hcp packing that is periodic along y needs an even number of rows");
  return {.hexagonal = kind == "hcp", .radius = r, .layers = layers};
}

/// The recipe's box is that of a dump, where none is told.
dem::Spheres read_file(Table& t, RveScene& scene, std::uint8_t material) {
  dem::SphereFile file{t.path("path"), read_unit(t)};
  if (t.has("columns")) {
    std::istringstream names(t.text("columns"));
    for (std::string name; names >> name;) file.columns.push_back(name);
  }
  Groups groups(t, scene.model, material);
  dem::ReadSpheres read;
  try {
    read = dem::read_spheres(file);
    if (scene.recipe.box.isZero()) scene.recipe.box = read.packing.box;
    dem::check_spheres(read, file.path, scene.recipe.box, scene.recipe.first_walls());
  } catch (const InputError& e) {
    t.fail("path", e.what());
  }
  dem::Spheres s{std::move(read.packing.spheres), material};
  for (std::size_t i = 0; i < read.group.size(); ++i) {
    const std::string& name = read.group[i];
    if (const auto of = groups.material_or_none(name))
      s.materials.push_back(*of);
    else
      t.fail("path", fmt::format("{}:{}: \"{}\" is no material of this scene; name one for it in [[packing.group]]",
                                 file.path, read.line[i], name));
  }
  groups.finish();
  return s;
}

}  // namespace

void check_cylinder(const Table& t, const dem::Vec3& box) {
  if (box[0] != box[1]) t.fail("box", "of a cylinder expected [diameter, diameter, height]");
}

void read_packing(Table t, RveScene& scene) {
  const std::string kind =
      t.choice("kind", {"random", "hcp", "simple-cubic", "file", "voronoi", "prisms", "polyhedra"});
  dem::Recipe& recipe = scene.recipe;
  const bool round = recipe.bounds == dem::Bounds::cylinder;
  if (t.has("box")) {
    recipe.box = vector3(t.numbers("box", 3, dimension::length));
    if (!(recipe.box.minCoeff() > 0)) t.fail("box", "all three sides must be above 0");
  }
  scene.model.seed = static_cast<std::uint64_t>(t.integer_or("seed", static_cast<long>(scene.model.seed), 0, 1L << 62));
  const std::string name = t.text_or("material", scene.model.materials.front().name);
  const auto material = material_of(t, scene.model, name);
  if (kind == "voronoi" || kind == "prisms" || kind == "polyhedra") {
    if (scene.scale != 1) t.fail("kind", "loading.scale is for random packings");
    (kind == "voronoi" ? read_voronoi : kind == "prisms" ? read_prisms : read_polyhedra)(t, scene, material);
    t.finish();
    return;
  }
  const bool turned = t.choice_or("orientation", "random", {"random", "aligned"}) == "random";
  if (kind == "random") {
    if (t.has("parents")) {
      recipe.grains = read_agglomerates(t, scene, material);
      t.finish();
      return;
    }
    if (recipe.box.isZero()) t.fail("", "box is missing");
    if (round) check_cylinder(t, recipe.box);
    recipe.grains = read_random(t, scene, turned, material);
    t.finish();
    return;
  }
  if (round && kind != "file") t.fail("kind", "a cylinder takes \"random\" or \"file\"");
  if (scene.scale != 1) t.fail("kind", "loading.scale is for random packings");
  double smallest = INFINITY, largest = 0;
  if (kind == "file") {
    dem::Spheres s = read_file(t, scene, material);
    s.turned = turned;
    s.round = read_round(t, scene);
    for (const auto& sphere : s.spheres)
      smallest = std::min(smallest, sphere.radius), largest = std::max(largest, sphere.radius);
    recipe.grains = std::move(s);
  } else {
    dem::Lattice l = read_lattice(t, kind, recipe);
    l.material = material, l.turned = turned;
    smallest = largest = l.radius;
    recipe.box = dem::box_of(l, recipe.repeats());
    if (!recipe.periodic()) recipe.box.z() = dem::box_of(l, false).z();
    recipe.grains = l;
  }
  const auto* mixed = std::get_if<dem::Spheres>(&recipe.grains);
  for (std::size_t i = 0; mixed && i < mixed->materials.size(); ++i)
    check_mass(t, scene.model.materials[mixed->materials[i]], mixed->spheres[i].radius, "path");
  for (const double r : {smallest, largest})
    check_mass(t, scene.model.materials[material], r, kind == "file" ? "path" : "radius");
  t.finish();
}

}  // namespace grus::app
