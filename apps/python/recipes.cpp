// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/python/recipes.hpp"

#include <pybind11/stl.h>

#include <nlohmann/json.hpp>

#include "dem/sample/network.hpp"
#include "dem/sample/prepare.hpp"

namespace grus::python {
namespace {

namespace py = pybind11;
using dem::Vec3;
using Triple = std::array<double, 3>;

template <class T>
T get(const py::dict& d, const char* key) {
  return d[key].cast<T>();
}

Vec3 vector(const py::dict& d, const char* key) {
  const auto v = get<Triple>(d, key);
  return {v[0], v[1], v[2]};
}

dem::BondModel bond_of(const py::dict& d, double friction) {
  dem::BondModel b;
  const dem::Network network = dem::network_of({get<double>(d, "modulus"), get<double>(d, "poissons_ratio")});
  b.stiffness = network.stiffness, b.ratio = network.ratio, b.friction = friction;
  b.tension = get<double>(d, "tension"), b.cohesion = get<double>(d, "cohesion");
  b.tan_phi = std::tan(get<double>(d, "friction_angle"));
  b.energy_1 = get<double>(d, "fracture_energy"), b.energy_2 = get<double>(d, "shear_energy");
  b.between = get<double>(d, "between"), b.damping = get<double>(d, "damping"), b.weibull = get<double>(d, "weibull");
  return b;
}

dem::Material material_of(const py::dict& d, bool hulls) {
  dem::Material m;
  m.name = get<std::string>(d, "name"), m.density = get<double>(d, "density");
  m.youngs_modulus = get<double>(d, "youngs_modulus"), m.poissons_ratio = get<double>(d, "poissons_ratio");
  m.friction = get<double>(d, "friction"), m.rolling_friction = get<double>(d, "rolling_friction");
  m.restitution = get<double>(d, "restitution"), m.damping = get<double>(d, "damping");
  m.turns = get<bool>(d, "rotation");
  if (!hulls) return m;
  if (!d["bond"].is_none()) m.bond = bond_of(get<py::dict>(d, "bond"), m.friction);
  dem::Foundation::Of press;
  press.modulus = m.bond ? m.bond->stiffness : m.youngs_modulus;
  press.shear_ratio = m.bond ? m.bond->ratio : 2.0 / 7;
  m.contact = press;
  m.youngs_modulus = dem::Material().youngs_modulus;  // hulls press with their foundation
  return m;
}

dem::RandomPacking random_of(const py::dict& d) {
  dem::RandomPacking p;
  const auto [least, most] = get<std::pair<double, double>>(d, "radius");
  p.radius = {.mean = 0.5 * (least + most)};
  if (least != most) p.radius.kind = "uniform", p.radius.min = least, p.radius.max = most;
  p.solid_fraction = get<double>(d, "solid_fraction"), p.count = get<std::size_t>(d, "count");
  p.turned = get<bool>(d, "turned");
  p.parts.clear();
  for (const auto& part : get<std::vector<py::dict>>(d, "parts"))
    p.parts.push_back({get<std::uint8_t>(part, "material"), get<double>(part, "share"), vector(part, "aspect")});
  if (get<bool>(d, "balls"))
    p.hulls = {.aspect = vector(d, "aspect"), .balls = true};
  else if (!d["hulls"].is_none())
    p.hulls = {.rounds = get<int>(d, "hulls"), .aspect = vector(d, "aspect")};
  return p;
}

dem::Spheres spheres_of(const py::dict& d) {
  dem::Spheres s;
  for (const auto& x : get<std::vector<std::array<double, 4>>>(d, "spheres"))
    s.spheres.push_back({Vec3(x[0], x[1], x[2]), x[3]});
  s.turned = get<bool>(d, "turned"), s.material = get<std::uint8_t>(d, "material");
  return s;
}

dem::Listed listed_of(const py::dict& d) {
  dem::Listed listed;
  for (const auto& of : get<std::vector<py::dict>>(d, "grains")) {
    dem::ListedGrain grain;
    dem::GrainSpec& spec = grain.spec;
    spec.position = vector(of, "position"), spec.velocity = vector(of, "velocity"), spec.spin = vector(of, "spin");
    const auto q = get<std::array<double, 4>>(of, "orientation");  // x y z w, as grains() tells it
    spec.orientation = dem::Quat(q[3], q[0], q[1], q[2]);
    spec.material = get<std::uint8_t>(of, "material");
    if (of["vertices"].is_none()) {
      const auto a = get<std::array<double, 6>>(of, "semi_axes");
      spec.shape.plus = {a[0], a[2], a[4]}, spec.shape.minus = {a[1], a[3], a[5]};
    } else {
      grain.vertices.emplace();
      for (const auto& v : get<std::vector<Triple>>(of, "vertices")) grain.vertices->emplace_back(v[0], v[1], v[2]);
    }
    listed.push_back(std::move(grain));
  }
  return listed;
}

void read_grains(const py::dict& d, dem::Recipe& recipe) {
  const auto kind = get<std::string>(d, "kind");
  if (kind == "random") recipe.grains = random_of(d);
  if (kind == "spheres") recipe.grains = spheres_of(d);
  if (kind == "listed") recipe.grains = listed_of(d);
  if (kind == "voronoi")
    recipe.grains = dem::VoronoiPacking{.count = get<std::size_t>(d, "cells"),
                                        .rounds = get<int>(d, "relax"),
                                        .clusters = get<std::size_t>(d, "clusters"),
                                        .material = get<std::uint8_t>(d, "material")};
  if (kind != "lattice") return;
  const dem::Lattice lattice{.hexagonal = get<bool>(d, "hexagonal"),
                             .radius = get<double>(d, "radius"),
                             .layers = get<std::array<int, 3>>(d, "layers"),
                             .material = get<std::uint8_t>(d, "material"),
                             .turned = get<bool>(d, "turned")};
  recipe.grains = lattice, recipe.box = dem::box_of(lattice, true);
}

}  // namespace

app::RveScene scene_of(const py::dict& asked, const std::string& name) {
  app::RveScene scene;
  scene.file = scene.title = name;
  dem::Model& model = scene.model;
  const auto hulls = get<bool>(asked, "hulls");
  for (const auto& m : get<std::vector<py::dict>>(asked, "materials")) model.materials.push_back(material_of(m, hulls));
  if (hulls) model.law = dem::Foundation{};
  model.seed = get<std::uint64_t>(asked, "seed");
  model.numerics.safety = app::unit_cell_safety(model);
  scene.recipe.bounds = dem::Bounds::periodic;
  if (!asked["box"].is_none()) scene.recipe.box = vector(asked, "box");
  read_grains(get<py::dict>(asked, "grains"), scene.recipe);
  model.motion.turn_spheres = scene.listed_grains() > 0;
  dem::make_pair_laws(model);
  if (!asked["pressure"].is_none()) {
    const double pressure = get<double>(asked, "pressure");
    scene.recipe.preparation = dem::Preparation{.pressure = pressure, .friction = get<double>(asked, "friction")};
    if (const std::string why = dem::unbearable(model, scene.recipe, pressure); !why.empty())
      dem::refuse(name + ": pressure", why);
  }
  scene.record = std::make_shared<const nlohmann::json>(nlohmann::json::parse(get<std::string>(asked, "record")));
  return scene;
}

}  // namespace grus::python
