// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/hulls_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "apps/scene/packing_scene.hpp"
#include "dem/state/order.hpp"

namespace grus::app {
namespace {

using dem::Vec3;

/// Moduli of networks of relaxed periodic cells by the ratio of their shear stiffness, over that of the network.
struct NetworkRow {
  double ratio, youngs, poisson;
};
constexpr NetworkRow network[] = {{1, 1, 0},           {0.7, .8703, .0649}, {0.4, .7150, .1425},
                                  {0.2, .5881, .2059}, {0.1, .5114, .2443}, {0.05, .4666, .2667}};

/// Stiffness ratio and modulus of the network that show a modulus and Poisson's ratio.
void find_network(double youngs, double poisson, dem::BondModel& b) {
  std::size_t k = 1;
  while (k + 1 < std::size(network) && network[k].poisson < poisson) ++k;
  const NetworkRow &low = network[k - 1], &high = network[k];
  const double share = (poisson - low.poisson) / (high.poisson - low.poisson);
  b.ratio = low.ratio + share * (high.ratio - low.ratio);
  b.stiffness = youngs / (low.youngs + share * (high.youngs - low.youngs));
}

void read_cohesive(Table& t, dem::BondModel& b) {
  b.tension = t.number("tension", dimension::pressure, positive);
  b.cohesion = t.number("cohesion", dimension::pressure, positive);
  b.tan_phi = std::tan(t.number_or("friction_angle", 0, dimension::angle, {0, 0.49 * dem::pi}));
  b.energy_1 = t.number("fracture_energy", dimension::surface_energy, positive);
  b.energy_2 = t.number_or("shear_energy", b.energy_1, dimension::surface_energy, positive);
  if (t.has("between")) b.between = t.number("between", dimension::pressure, positive);
}

void read_strain_sum(Table& t, dem::BondModel& b) {
  b.criterion = dem::FaceCriterion::strain_sum;
  b.tension = t.number("strain", dimension::none, positive);
  b.cohesion = t.number_or("rotation", INFINITY, dimension::angle, positive);
}

void read_parallel(Table& t, dem::BondModel& b) {
  b.criterion = dem::FaceCriterion::parallel;
  b.tension = t.number("tension", dimension::pressure, positive);
  b.cohesion = t.number("shear", dimension::pressure, positive);
  if (t.has("between")) b.between = t.number("between", dimension::pressure, positive);
  b.tan_phi = std::tan(t.number_or("friction_angle", 0, dimension::angle, {0, 0.49 * dem::pi}));
}

}  // namespace

dem::BondModel read_bond(Table t, double friction, std::optional<Elasticity>& elasticity) {
  dem::BondModel b;
  b.friction = friction;
  if (t.has("normal_stiffness") == t.has("modulus")) t.fail("", "needs either modulus or normal_stiffness");
  if (t.has("modulus")) {
    const double modulus = t.number("modulus", dimension::pressure, positive);
    const double poisson = t.number_or("poissons_ratio", 0.2, dimension::none, {-1, 0.5, false, true});
    if (poisson < 0 || poisson > 0.26)
      t.fail("poissons_ratio", fmt::format("{:g}: rigid cells and springs of faces show 0 to 0.26", poisson));
    if (t.has("shear_ratio")) t.fail("shear_ratio", "follows from poissons_ratio; or give normal_stiffness");
    find_network(modulus, poisson, b);
    elasticity = {modulus, poisson};
  } else {
    b.stiffness = t.number("normal_stiffness", dimension::foundation, positive);
    b.stiffness_given = true;
    b.ratio = t.number_or("shear_ratio", 0.4, dimension::none, {0, 1, true});
  }
  if (t.has("length")) {
    if (b.stiffness_given) t.fail("length", "normal_stiffness is per area: no length is needed");
    b.length = t.number("length", dimension::length, positive);
  }
  const std::string criterion = t.choice_or("criterion", "cohesive", {"cohesive", "strain-sum", "parallel"});
  if (criterion == "cohesive") read_cohesive(t, b);
  if (criterion == "strain-sum") read_strain_sum(t, b);
  if (criterion == "parallel") read_parallel(t, b);
  b.damping = t.number_or("damping", 0, dimension::none, {0, 1, false, true});
  b.weibull = t.number_or("weibull", 0, dimension::none, {1, 1000});
  t.finish();
  return b;
}

void read_hull(Table& t, dem::Grains& grains, dem::GrainSpec& spec, std::vector<std::string>& notes) {
  if (t.has("vertices") == t.has("box")) t.fail("", "a hull needs either vertices or box");
  dem::Polyhedron body;
  try {
    if (t.has("box")) {
      const Vec3 box = vector3(t.numbers("box", 3, dimension::length));
      if (!(box.minCoeff() > 0)) t.fail("box", "all three sides must be above 0");
      body = dem::box_between(-0.5 * box, 0.5 * box);
    } else {
      std::vector<Vec3> points;
      for (const auto& p : t.points("vertices", dimension::length)) points.emplace_back(p[0], p[1], p[2]);
      body = dem::hull_of(points);
      if (body.vertex.size() < points.size())
        notes.push_back(fmt::format("{}: {} of {} vertices are no corners of the convex hull and are left out",
                                    t.place("vertices"), points.size() - body.vertex.size(), points.size()));
    }
    // Nobody else has the store while a scene is read; a copy for each hull would make thousands slow.
    auto store = std::const_pointer_cast<dem::HullStore>(grains.hulls);
    if (!store) store = std::make_shared<dem::HullStore>();
    dem::HullPlace place;
    spec.hull = dem::add_hull(*store, body, place);
    spec.orientation = spec.orientation * place.axes;
    grains.hulls = store;
  } catch (const dem::InputError& e) {
    t.fail("vertices", e.what());
  }
}

void put_hulls(const dem::Packing& packing, const std::vector<dem::UnitHull>& hulls, std::uint8_t material, bool turned,
               RveScene& scene) {
  scene.packing_overlap = packing.worst_overlap;
  dem::Grains& g = scene.state.grains;
  dem::HullStore store;
  std::map<std::pair<std::size_t, double>, std::pair<dem::Index, dem::HullPlace>> rows;
  for (std::size_t i = 0; i < packing.spheres.size(); ++i) {
    const std::size_t k = i % hulls.size();
    const double scale = packing.spheres[i].radius / hulls[k].reach;
    const auto [row, fresh] = rows.try_emplace({k, scale});
    if (!fresh) continue;
    dem::Polyhedron body = hulls[k].body;
    dem::stretch(body, Vec3::Constant(scale));
    row->second.first = dem::add_hull(store, body, row->second.second);
  }
  g.hulls = std::make_shared<dem::HullStore>(std::move(store));
  for (std::size_t i = 0; i < packing.spheres.size(); ++i) {
    const std::size_t k = i % hulls.size();
    const auto& [row, at] = rows.at({k, packing.spheres[i].radius / hulls[k].reach});
    dem::GrainSpec spec;
    spec.hull = row;
    spec.position = packing.spheres[i].position;
    spec.material = material;
    spec.density = scene.model.materials[material].density;
    spec.inertia = scene.model.numerics.inertia_factor(std::cbrt(3 * g.hulls->row[row].volume / (4 * dem::pi)));
    spec.orientation = turned ? dem::random_rotation(scene.model.seed, i) * at.axes : at.axes;
    dem::set_grain(g, i, spec);
  }
  dem::sort_in_space(g);
}

void check_hulls(const Table& t, const RveScene& scene) {
  const auto& kinds = scene.state.grains.kind;
  const bool by_overlap = dem::of_hulls(scene.model.law);
  const auto hulls = std::count(kinds.begin(), kinds.end(), dem::ShapeKind::hull);
  if (!scene.of_hulls() && !by_overlap) return;
  if (!scene.of_hulls())
    t.fail("material",
           "contact = \"overlap\" is for hulls: packing.kind = \"voronoi\", packing.hulls, or shape = "
           "\"hull\"");
  if (static_cast<std::size_t>(hulls) != kinds.size())
    t.fail("grain", "hulls meet hulls and walls alone; a scene has either hulls or other shapes");
  if (!by_overlap) t.fail("material", "hulls need contact = \"overlap\"");
  if (dem::cylinder(scene.state.boundary))
    t.fail("boundary", "hulls cannot be in a cylinder yet; use walls or \"open\"");
  for (const auto& m : scene.model.materials) {
    if (m.fracture && !std::holds_alternative<dem::Cut>(m.fracture->splitter))
      t.fail("material", fmt::format("{}.fracture: hulls are cut by model = \"cleavage\"", m.name));
    if (!m.turns) t.fail("material", fmt::format("{}.rotation = false is for spheres", m.name));
  }
}

}  // namespace grus::app
