// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/bodies_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include <sstream>

#include "apps/scene/packing_scene.hpp"
#include "dem/base/text_file.hpp"
#include "dem/packing/surfaces.hpp"

namespace grus::app {
namespace {

using dem::Vec3;

constexpr double most_bodies = 5e5;

struct Extents {
  Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);

  explicit Extents(const std::vector<dem::Polyhedron>& bodies) {
    for (const auto& body : bodies)
      for (const Vec3& x : body.vertex) low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
};

/// The box where none is told: that which the bodies take, which move into it. Else they must be in it.
void fit_box(Table& t, RveScene& scene, dem::Bodies& bodies) {
  const Extents e(bodies.body);
  Vec3& box = scene.recipe.box;
  if (box.isZero()) {
    if (scene.recipe.periodic()) t.fail("", "box is missing: a periodic cell repeats by it");
    for (auto& body : bodies.body) dem::place(body, dem::Mat3::Identity(), -e.low);
    for (Vec3& x : bodies.middle) x -= e.low;
    box = e.high - e.low;
    return;
  }
  const double slack = bodies.tolerance * box.maxCoeff();
  const bool inside = (e.low.array() >= -slack).all() && (e.high.array() <= box.array() + slack).all();
  if (scene.recipe.bounds == dem::Bounds::walls && !inside)
    t.fail("box", fmt::format("the bodies are from {:g}, {:g}, {:g} to {:g}, {:g}, {:g} m, not inside of it: is the "
                              "file's unit {:g} m?",
                              e.low.x(), e.low.y(), e.low.z(), e.high.x(), e.high.y(), e.high.z(),
                              t.has("unit") ? read_unit(t) : 1));
}

}  // namespace

Groups::Groups(Table& packing, const dem::Model& model, std::uint8_t otherwise)
    : model_(&model), otherwise_(otherwise) {
  for (Table g : packing.tables("group")) {
    const std::string name = g.text("name");
    const auto material = material_of(g, model, g.text("material"));
    if (!group_.try_emplace(name, Group{material, false, g.place("name")}).second)
      g.fail("name", fmt::format("\"{}\": there is a group of that name already", name));
    g.finish();
  }
}

std::uint8_t Groups::material(const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (const auto found = group_.find(name); found != group_.end()) {
      found->second.found = true;
      return found->second.material;
    }
  return otherwise_;
}

std::optional<std::uint8_t> Groups::material_or_none(const std::string& name) {
  if (group_.contains(name)) return material({name});
  for (std::size_t i = 0; i < model_->materials.size(); ++i)
    if (model_->materials[i].name == name) return static_cast<std::uint8_t>(i);
  return {};
}

void Groups::finish() const {
  for (const auto& [name, group] : group_)
    if (!group.found) dem::refuse(group.place, fmt::format("\"{}\": nothing in the file is of that group", name));
}

double read_unit(Table& t) {
  const std::string unit = t.text_or("unit", "m");
  try {
    return parse_quantity("1 " + unit, dimension::length).value;
  } catch (const std::invalid_argument& e) {
    t.fail("unit", fmt::format("\"{}\": {}; write a unit of length such as \"mm\"", unit, e.what()));
  }
}

std::vector<Vec3> read_points(const std::string& path, double unit) {
  const auto in = dem::open_text(path);
  if (!in) throw InputError(path + ": no such file");
  std::vector<Vec3> points;
  int number = 0;
  for (std::string line; std::getline(*in, line);) {
    ++number;
    std::istringstream words(line.substr(0, line.find('#')));
    std::string rest;
    if (!(words >> rest)) continue;
    words.seekg(0);
    Vec3 x;
    if (!(words >> x[0] >> x[1] >> x[2]) || (words >> rest) || !x.allFinite())
      throw InputError(fmt::format("{}:{}: expected three numbers x y z", path, number));
    points.emplace_back(unit * x);
  }
  if (points.empty()) throw InputError(path + ": no points in it");
  return points;
}

void read_polyhedra(Table& t, RveScene& scene, std::uint8_t material) {
  dem::Bodies bodies;
  bodies.place = t.place("path");
  bodies.tolerance = t.number_or("tolerance", bodies.tolerance, dimension::none, {0, 0.01, true});
  bodies.round = t.flag_or("round", false);
  const double unit = read_unit(t);
  Groups groups(t, scene.model, material);
  try {
    for (dem::Surface& surface : dem::read_surfaces(t.path("path"))) {
      for (Vec3& x : surface.corner) x *= unit;
      bodies.body.push_back(dem::body_of(surface, bodies.tolerance));
      bodies.middle.push_back(surface.seed ? Vec3(unit * *surface.seed) : dem::moments_of(bodies.body.back()).centre);
      bodies.materials.push_back(groups.material(surface.group));
      const double radius = std::cbrt(dem::moments_of(bodies.body.back()).volume * 3 / (4 * dem::pi));
      check_mass(t, scene.model.materials[bodies.materials.back()], radius, "path");
    }
  } catch (const InputError& e) {
    if (std::string(e.what()).starts_with(bodies.place)) throw;
    t.fail("path", e.what());
  }
  groups.finish();
  if (static_cast<double>(bodies.body.size()) > most_bodies) t.fail("path", "more than half a million bodies");
  fit_box(t, scene, bodies);
  if (bodies.round) check_cylinder(t, scene.recipe.box);
  scene.recipe.grains = std::move(bodies);
}

}  // namespace grus::app
