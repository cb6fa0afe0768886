// SPDX-License-Identifier: LGPL-3.0-or-later
// [packing], [[grain]], [[wall]] and [boundary]: what is there at the start.
#include "apps/scene/sample_scene.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "dem/state/order.hpp"

namespace grus::app {
namespace {

using dem::Vec3;

Vec3 vector3(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

std::uint8_t material_of(Table& t, const dem::Model& model, const std::string& name) {
  for (std::size_t i = 0; i < model.materials.size(); ++i)
    if (model.materials[i].name == name) return static_cast<std::uint8_t>(i);
  std::vector<std::string> names;
  for (const auto& m : model.materials) names.push_back(m.name);
  const std::string near = closest(name, names);
  t.fail("material", fmt::format("\"{}\": no such material{}", name, near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near)));
}

/// A rigid material for walls; its friction replaces that of the grains unless NaN.
std::uint8_t rigid_material(dem::Model& model, double friction) {
  dem::Material m;
  m.name = fmt::format("rigid-{}", model.materials.size());
  m.youngs_modulus = INFINITY;
  m.friction = friction;
  model.materials.push_back(m);
  return static_cast<std::uint8_t>(model.materials.size() - 1);
}

dem::RadiusDistribution read_radius(Table& packing) {
  dem::RadiusDistribution d;
  Table t = packing.table("radius");
  d.kind = t.choice("distribution", {"constant", "uniform", "truncated-normal"});
  if (d.kind == "uniform") {
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

void read_packing_table(Table t, RveScene& scene, Vec3& box) {
  const std::string kind = t.choice("kind", {"random", "hcp", "simple-cubic", "file"});
  const bool periodic = scene.state.boundary.cell.periodic();
  if (t.has("box")) {
    box = vector3(t.numbers("box", 3, dimension::length));
    if (!(box.minCoeff() > 0)) t.fail("box", "all three sides must be above 0");
  }
  scene.model.seed = static_cast<std::uint64_t>(t.integer_or("seed", 1, 0, 1L << 62));
  dem::Packing packing;
  if (kind == "random") {
    if (box.isZero()) t.fail("", "packing.box is missing");
    const auto radius = read_radius(t);
    const double phi = t.number("solid_fraction", dimension::none, proper_fraction);
    if (phi > 0.64) t.fail("solid_fraction", fmt::format("{:g}: spheres do not pack denser than 0.64 at random", phi));
    const long count = t.integer_or("count", 0, 0, 20000000);
    const double volume = 4 * dem::pi / 3 * std::pow(radius.mean, 3);
    if (phi * box.prod() / volume > 5e6) t.fail("box", "more than five million grains; check box and radius");
    packing = dem::random_packing(box, radius, phi, static_cast<std::size_t>(count), periodic, scene.model.seed);
  } else if (kind == "file") {
    std::filesystem::path file = t.text("path");
    if (file.is_relative()) file = std::filesystem::path(scene.file).parent_path() / file;
    packing = dem::read_packing(file.string(), box);
  } else {
    const double r = read_radius(t).mean;
    std::array<int, 3> layers{};
    if (t.has("layers")) {
      const auto v = t.numbers("layers", 3, dimension::none);
      for (int k = 0; k < 3; ++k) {
        layers[k] = static_cast<int>(v[k]);
        if (v[k] != layers[k] || layers[k] < 1) t.fail("layers", "expected three whole numbers from 1");
      }
    } else {
      if (box.isZero()) t.fail("", "packing.box or packing.layers is missing");
      for (int k = 0; k < 3; ++k) layers[k] = std::max(1, static_cast<int>(box[k] / (2 * r) + 1e-9));
      if (kind == "hcp") {
        layers[1] = std::max(1, 1 + static_cast<int>((box[1] - 2 * r - r / std::sqrt(3.0)) / (std::sqrt(3.0) * r) + 1e-9));
        layers[0] = std::max(1, static_cast<int>((box[0] / r - 1) / 2 + 1e-9));
        layers[2] = std::max(1, 1 + static_cast<int>((box[2] - 2 * r) / (std::sqrt(8.0 / 3) * r) + 1e-9));
      }
    }
    packing = kind == "hcp" ? dem::hexagonal_close(r, layers) : dem::simple_cubic(r, layers);
    if (periodic && kind == "hcp") {
      if (layers[1] % 2 || layers[2] % 2) t.fail("layers", "a periodic hcp packing needs even numbers of rows and layers");
      packing.box = Vec3(2 * r * layers[0], std::sqrt(3.0) * r * layers[1], std::sqrt(8.0 / 3) * r * layers[2]);
    }
    box = packing.box;
  }
  scene.packing_overlap = packing.worst_overlap;
  const std::string name = t.text_or("material", scene.model.materials.front().name);
  const auto material = material_of(t, scene.model, name);
  const double density = scene.model.materials[material].density;
  const std::string turned = t.choice_or("orientation", "random", {"random", "aligned"});
  for (std::size_t i = 0; i < packing.spheres.size(); ++i) {
    dem::GrainSpec spec;
    spec.shape = dem::PolyEllipsoid::sphere(packing.spheres[i].radius);
    spec.position = packing.spheres[i].position;
    spec.material = material;
    spec.density = density;
    if (turned == "random") spec.orientation = dem::random_rotation(scene.model.seed, i);
    dem::set_grain(scene.state.grains, i, spec);
  }
  dem::sort_in_space(scene.state.grains);
  t.finish();
}

void read_grain(Table t, RveScene& scene) {
  dem::GrainSpec spec;
  const std::string shape = t.choice_or("shape", "sphere", {"sphere", "polyellipsoid"});
  if (shape == "sphere") {
    spec.shape = dem::PolyEllipsoid::sphere(t.number("radius", dimension::length, positive));
  } else {
    const auto a = t.numbers("semi_axes", 6, dimension::length);
    for (int k = 0; k < 3; ++k) spec.shape.plus[k] = a[2 * k], spec.shape.minus[k] = a[2 * k + 1];
    const double least = *std::min_element(a.begin(), a.end()), most = *std::max_element(a.begin(), a.end());
    if (!(least > 0)) t.fail("semi_axes", "all six must be above 0");
    if (most > 1000 * least) t.fail("semi_axes", "the longest is more than 1000 times the shortest");
  }
  spec.position = vector3(t.numbers("position", 3, dimension::length));
  spec.velocity = vector3(t.numbers_or("velocity", {0, 0, 0}, dimension::speed));
  spec.spin = vector3(t.numbers_or("spin", {0, 0, 0}, dimension::rate));
  const auto q = t.numbers_or("orientation", {1, 0, 0, 0}, dimension::none);
  spec.orientation = dem::Quat(q[0], q[1], q[2], q[3]);
  if (std::abs(spec.orientation.norm() - 1) > 1e-3) t.fail("orientation", "must be a unit quaternion w, x, y, z");
  spec.material = material_of(t, scene.model, t.text_or("material", scene.model.materials.front().name));
  spec.density = scene.model.materials[spec.material].density;
  dem::set_grain(scene.state.grains, scene.state.grains.size(), spec);
  t.finish();
}

void read_wall(Table t, RveScene& scene) {
  dem::Wall wall;
  wall.point = vector3(t.numbers("point", 3, dimension::length));
  wall.normal = vector3(t.numbers("normal", 3, dimension::none));
  if (!(wall.normal.norm() > 0)) t.fail("normal", "must not be zero");
  if (std::abs(wall.normal.norm() - 1) > 1e-12) wall.normal.normalize();
  wall.velocity = vector3(t.numbers_or("velocity", {0, 0, 0}, dimension::speed));
  const bool rigid = t.flag_or("rigid", !t.has("material"));
  if (rigid && t.has("material")) t.fail("rigid", "a wall is either rigid or of a material");
  if (!rigid && t.has("friction")) t.fail("friction", "a wall of a material has that material's friction");
  if (!rigid && !t.has("material")) t.fail("", "needs material, or rigid = true");
  wall.material = rigid ? rigid_material(scene.model, t.number_or("friction", NAN, dimension::none, not_negative))
                        : material_of(t, scene.model, t.text("material"));
  scene.state.boundary.walls.push_back(wall);
  t.finish();
}

}  // namespace

void read_sample(Table& t, RveScene& scene) {
  dem::Boundary& boundary = scene.state.boundary;
  std::string kind = "open";
  double friction = NAN;
  std::string wall_material;
  std::optional<Table> b = t.table_if("boundary");
  if (b) {
    kind = b->choice("kind", {"walls", "periodic", "open"});
    if (kind == "walls") {
      if (b->has("material")) wall_material = b->text("material");
      else friction = b->number_or("friction", NAN, dimension::none, not_negative);
    }
  }
  if (kind == "periodic") boundary.cell.vectors.setIdentity();  // sized by the packing below
  Vec3 box = Vec3::Zero();
  const auto grains = t.tables("grain");
  if (auto p = t.table_if("packing")) {
    if (!grains.empty()) t.fail("packing", "a scene has either [packing] or [[grain]]");
    read_packing_table(*p, scene, box);
  }
  for (const auto& g : grains) read_grain(g, scene);
  scene.listed_grains = grains.size();
  for (auto& w : t.tables("wall")) {
    if (kind == "periodic") w.fail("", "a periodic cell has no walls");
    read_wall(w, scene);
  }
  if (scene.state.grains.size() == 0) t.fail("", "the scene has no grains: give [packing] or [[grain]]");
  if (kind != "open" && box.isZero()) {
    if (!b->has("box")) b->fail("box", "needs the size of the box: boundary.box, or packing.box");
    box = vector3(b->numbers("box", 3, dimension::length));
    if (!(box.minCoeff() > 0)) b->fail("box", "all three sides must be above 0");
  }
  if (kind == "periodic") boundary.cell.vectors = dem::Mat3(box.asDiagonal());
  if (kind == "walls") {
    if (!boundary.walls.empty()) b->fail("kind", "\"walls\" makes the six walls of the box; use \"open\" with [[wall]]");
    const auto material = wall_material.empty() ? rigid_material(scene.model, friction) : material_of(*b, scene.model, wall_material);
    for (int k = 0; k < 3; ++k)
      for (int side = 0; side < 2; ++side) {
        dem::Wall wall;
        wall.point = wall.normal = Vec3::Zero();
        wall.normal[k] = side ? -1 : 1;
        if (side) wall.point[k] = box[k];
        wall.material = material;
        wall.name = fmt::format("{}{}", "xyz"[k], side ? "max" : "min");
        boundary.walls.push_back(wall);
      }
  }
  if (b) b->finish();
  // Impossible starts are refused, not pushed apart: their energy would be nobody's.
  dem::update_frames(scene.state.grains);
  for (std::size_t i = 0; i < scene.listed_grains; ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (scene.state.grains.motion[i].position == scene.state.grains.motion[j].position)
        t.fail("grain", fmt::format("grains {} and {} have the same centre", j, i));
}

void add_platens(RveScene& scene, int axis, double speed, double friction) {
  double low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < scene.state.grains.size(); ++i) {
    Vec3 up = Vec3::Zero();
    up[axis] = 1;
    const double x = scene.state.grains.motion[i].position[axis];
    high = std::max(high, x + dem::surface_arm(scene.state.grains, i, up)[axis]);
    low = std::min(low, x + dem::surface_arm(scene.state.grains, i, -up)[axis]);
  }
  const auto material = rigid_material(scene.model, friction);
  for (int side = 0; side < 2; ++side) {
    dem::Wall wall;
    wall.point = wall.normal = wall.velocity = Vec3::Zero();
    wall.normal[axis] = side ? -1 : 1;
    wall.point[axis] = side ? high : low;
    if (side) wall.velocity[axis] = -speed;
    wall.material = material;
    wall.name = side ? "top" : "bottom";
    scene.state.boundary.walls.push_back(wall);
  }
}

}  // namespace grus::app
