// SPDX-License-Identifier: LGPL-3.0-or-later
// [[grain]], [[wall]] and [boundary]: what is there at the start; [packing] is in packing_scene.cpp.
#include "apps/scene/sample_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "apps/scene/hulls_scene.hpp"
#include "apps/scene/packing_scene.hpp"
#include "apps/scene/speeds.hpp"
#include "apps/scene/supports_scene.hpp"
#include "apps/scene/wall_scene.hpp"
#include "dem/packing/random_hulls.hpp"

namespace grus::app {
namespace {

using dem::Vec3;

constexpr std::size_t most_materials = 250;  // an index is a byte

}  // namespace

std::uint8_t rigid_material(const Table& at, dem::Model& model, double friction) {
  dem::Material m;
  m.name = fmt::format("rigid-{}", model.materials.size());
  m.youngs_modulus = INFINITY;
  m.friction = friction;
  for (std::size_t i = 0; i < model.materials.size(); ++i) {  // one is enough for all walls that are alike
    const dem::Material& other = model.materials[i];
    if (std::isinf(other.youngs_modulus) &&
        (other.friction == friction || (std::isnan(other.friction) && std::isnan(friction))))
      return static_cast<std::uint8_t>(i);
  }
  return add_material(at, model, m);
}

std::uint8_t add_material(const Table& at, dem::Model& model, dem::Material m) {
  if (model.materials.size() > most_materials)
    at.fail("", fmt::format("more than {} materials, those of walls with different friction counted", most_materials));
  model.materials.push_back(std::move(m));
  return static_cast<std::uint8_t>(model.materials.size() - 1);
}

void tell_uneven(std::span<const double> sides, std::vector<std::string>& notes) {
  constexpr double uneven = 1000;
  const auto [least, most] = std::minmax_element(sides.begin(), sides.end());
  if (*least > 0 && *most >= uneven * *least)
    notes.push_back(
        fmt::format("the sides of the box, {:g} m, differ by a factor of {:.3g}: has each the unit that is "
                    "meant?",
                    fmt::join(sides, " m, "), *most / *least));
}

namespace {

/// A hull of 32 planes, as large as a sphere of that radius.
void put_ball(const Table& t, double radius, dem::ListedGrain& grain) {
  grain.place = t.place(""), grain.place_of_size = t.place("radius");
  grain.vertices = dem::ball_of_planes(dem::Vec3::Ones()).body.vertex;
  for (dem::Vec3& v : *grain.vertices) v *= radius;
}

dem::ListedGrain read_grain(Table t, const dem::Model& model) {
  dem::ListedGrain grain;
  dem::GrainSpec& spec = grain.spec;
  const std::string shape = t.choice_or("shape", "sphere", {"sphere", "ball", "polyellipsoid", "hull"});
  const std::string name = t.text_or("material", model.materials.front().name);
  spec.material = material_of(t, model, name);
  const dem::Material& material = model.materials[spec.material];
  if (shape == "sphere" || shape == "ball") {
    const double radius = t.number("radius", dimension::length, positive);
    check_mass(t, material, radius, "radius");
    spec.shape = dem::PolyEllipsoid::sphere(radius);
    if (shape == "ball") put_ball(t, radius, grain);
  } else if (shape == "polyellipsoid") {
    const auto a = t.numbers("semi_axes", 6, dimension::length);
    spec.shape.plus = {a[0], a[2], a[4]};
    spec.shape.minus = {a[1], a[3], a[5]};
    const double least = *std::min_element(a.begin(), a.end()), most = *std::max_element(a.begin(), a.end());
    if (!(least > 0)) t.fail("semi_axes", "all six must be above 0");
    if (most > 1000 * least) t.fail("semi_axes", "the longest is more than 1000 times the shortest");
    for (const double r : {least, most}) check_mass(t, material, r, "semi_axes");
  }
  spec.position = vector3(t.numbers("position", 3, dimension::length));
  spec.velocity = read_velocity(t, model);
  spec.spin = vector3(t.numbers_or("spin", {0, 0, 0}, dimension::rate));
  if (!material.turns && !spec.spin.isZero())
    t.fail("spin", fmt::format("material.{}.rotation = false: its grains do not turn", material.name));
  const auto q = t.numbers_or("orientation", {1, 0, 0, 0}, dimension::none);
  spec.orientation = dem::Quat(q[0], q[1], q[2], q[3]);
  if (std::abs(spec.orientation.norm() - 1) > 1e-3) t.fail("orientation", "must be a unit quaternion w, x, y, z");
  if (shape == "hull") read_hull(t, grain);
  t.finish();
  return grain;
}

/// What is for spheres alone has no other grains, and none that halves would make.
void refuse_shapes(const Table& t, const RveScene& scene, const std::string& why) {
  const dem::Listed* listed = scene.recipe.listed();
  const auto shaped = [](const dem::ListedGrain& g) { return !g.hull() && !g.spec.shape.is_sphere(); };
  if (listed && std::any_of(listed->begin(), listed->end(), shaped))
    t.fail("grain", why + " needs a scene of spheres alone");
  const auto* random = std::get_if<dem::RandomPacking>(&scene.recipe.grains);
  const auto flat = [](const dem::Part& p) { return p.aspect.minCoeff() != p.aspect.maxCoeff(); };
  if (random && std::any_of(random->parts.begin(), random->parts.end(), flat))
    t.fail("packing", why + " needs a scene of spheres alone");
  for (const auto& m : scene.model.materials)
    if (m.fracture && std::holds_alternative<dem::Halves>(m.fracture->splitter))
      t.fail("material", fmt::format("{} needs spheres alone, which fragments of \"polyellipsoid-split\" ({}) are not; "
                                     "use \"apollonian-14\"",
                                     why, m.name));
}

/// Bonds are made between packed Voronoi cells and between the parts of a grain that cleaves; elsewhere nobody would
/// read the table.
void refuse_unbonded(const Table& t, const RveScene& scene) {
  if (scene.recipe.of_voronoi()) return;
  for (const auto& m : scene.model.materials)
    if (m.bond && m.bond->criterion != dem::FaceCriterion::rod &&
        !(m.fracture && std::holds_alternative<dem::Cut>(m.fracture->splitter)))
      t.fail(
          "material",
          fmt::format("{}.bond: bonds are made between the Voronoi cells of packing.kind \"voronoi\" or \"prisms\" and "
                      "bodies of \"polyhedra\"; nothing is bonded here: leave the table out",
                      m.name));
}

/// All that tables of the sample name as their material.
void named_materials(const nlohmann::json& record, std::set<std::string>& names) {
  if (record.is_object() && record.contains("material") && record["material"].is_string())
    names.insert(record["material"].get<std::string>());
  for (const auto& part : record)
    if (part.is_structured()) named_materials(part, names);
}

/// A material that nothing is of may be meant for another setting of the scene, or be a slip.
void tell_unused(RveScene& scene, const nlohmann::json& record, std::size_t own) {
  std::set<std::string> names;
  named_materials(record, names);
  for (std::size_t i = 1; i < own; ++i)  // the first is everybody's who names none
    if (const std::string& name = scene.model.materials[i].name; !names.contains(name))
      scene.notes.push_back(fmt::format("material.{}: no grain and no wall is of it", name));
}

/// A grain that its material's splitter can make nothing of would never break.
void refuse_unsplit(const Table& t, const RveScene& scene) {
  const auto balls = [&](std::uint8_t material) { return scene.model.materials[material].balls() != nullptr; };
  const auto fail = [&](std::size_t i) {
    t.fail("grain", fmt::format("grain {} is no sphere: \"apollonian-14\" splits spheres", i));
  };
  if (const auto* cells = dem::voronoi_material(scene.recipe); cells && balls(*cells)) fail(0);
  const dem::Listed* listed = scene.recipe.listed();
  for (std::size_t i = 0; listed && i < listed->size(); ++i)
    if (const auto& g = (*listed)[i]; balls(g.spec.material) && (g.hull() || !g.spec.shape.is_sphere())) fail(i);
}

/// Impossible starts are refused, not pushed apart: their energy would be nobody's.
void check_places(const Table& t, const RveScene& scene) {
  const dem::Listed* listed = scene.recipe.listed();
  if (!listed) return;
  const auto& g = *listed;
  for (std::size_t i = 0; i < g.size(); ++i) {
    const Vec3& x = g[i].spec.position;
    if (scene.recipe.repeats() && !(x.cwiseQuotient(scene.recipe.box).cwiseAbs().maxCoeff() < 1000))
      t.fail("grain", fmt::format("grain {} lies more than a thousand cells away from the cell at the origin", i));
    for (std::size_t j = 0; j < i; ++j)
      if (x == g[j].spec.position) t.fail("grain", fmt::format("grains {} and {} have the same centre", j, i));
  }
}

/// [boundary], but for its box and what it asks of Voronoi cells.
dem::Bounds read_bounds(Table& b, double& friction, std::string& material) {
  const std::string kind = b.choice("kind", {"walls", "cylinder", "periodic", "periodic-xy", "open"});
  if (kind == "periodic") return dem::Bounds::periodic;
  if (kind == "open") return dem::Bounds::open;
  if (b.has("material"))
    material = b.text("material");
  else
    friction = b.number_or("friction", NAN, dimension::none, not_negative);
  if (kind == "periodic-xy") return dem::Bounds::periodic_xy;
  return kind == "walls" ? dem::Bounds::walls : dem::Bounds::cylinder;
}

}  // namespace

void read_sample(Table& t, const nlohmann::json& record, RveScene& scene) {
  dem::Recipe& recipe = scene.recipe;
  const std::size_t own = scene.model.materials.size();  // before rigid walls
  double friction = NAN;
  std::string wall_material;
  std::optional<Table> b = t.table_if("boundary");
  if (b) recipe.bounds = read_bounds(*b, friction, wall_material);
  const bool walled = recipe.bounds == dem::Bounds::walls, round = recipe.bounds == dem::Bounds::cylinder;
  const auto grains = t.tables("grain");
  if (auto p = t.table_if("packing")) {
    if (!grains.empty()) t.fail("packing", "a scene has either [packing] or [[grain]]");
    read_packing(*p, scene);
  } else {
    dem::Listed listed;
    for (const auto& g : grains) listed.push_back(read_grain(g, scene.model));
    recipe.grains = std::move(listed);
  }
  if (!grains.empty() && scene.scale != 1) t.fail("grain", "loading.scale is for random packings");
  for (const Table& w : t.tables("wall")) {
    if (recipe.periodic()) w.fail("", "a periodic cell has no walls");
    read_wall(w, scene);
  }
  if (recipe.listed() && recipe.listed()->empty()) t.fail("", "the scene has no grains: give [packing] or [[grain]]");
  if (recipe.bounds != dem::Bounds::open && recipe.box.isZero()) {
    if (!b->has("box")) b->fail("box", "needs the size of the box: boundary.box, or packing.box");
    recipe.box = vector3(b->numbers("box", 3, dimension::length));
    if (!(recipe.box.minCoeff() > 0)) b->fail("box", "all three sides must be above 0");
    if (round) check_cylinder(*b, recipe.box);
  }
  if (recipe.has_sides()) {
    if (!recipe.walls.empty())
      b->fail("kind", fmt::format("\"{}\" makes its own walls; use \"open\" with [[wall]], or give [[wall]] a side",
                                  b->text("kind")));
    recipe.wall_material =
        wall_material.empty() ? rigid_material(*b, scene.model, friction) : material_of(*b, scene.model, wall_material);
  }
  if (walled) read_glue(*b, scene);
  if (b) b->finish();
  const auto held = std::find_if(scene.model.materials.begin(), scene.model.materials.end(),
                                 [](const dem::Material& m) { return !m.turns; });
  if (held != scene.model.materials.end())
    refuse_shapes(t, scene, fmt::format("material.{}.rotation = false", held->name));
  if (recipe.in_cylinder()) refuse_shapes(t, scene, "a cylinder");
  if (recipe.bounds == dem::Bounds::periodic_xy && recipe.of_voronoi())
    b->fail("kind", "\"periodic-xy\" is of loose grains, not of Voronoi cells");
  if (recipe.at_mesh()) refuse_shapes(t, scene, "a wall of triangles");
  if (recipe.at_mesh() && scene.model.stepper != &dem::explicit_stepper)
    t.fail("wall", "a wall of triangles needs explicit steps, not numerics.engine = \"implicit\"");
  if (recipe.at_mesh() && dem::attracts(scene.model.law))
    t.fail("wall", "a wall of triangles knows no contacts that attract (contact = \"jkr\")");
  if (dem::attracts(scene.model.law)) refuse_shapes(t, scene, "a contact law with attraction");
  refuse_unsplit(t, scene);
  refuse_unbonded(t, scene);
  tell_unused(scene, record, own);
  tell_uneven({recipe.box.data(), 3}, scene.notes);
  check_hulls(t, scene);
  check_places(t, scene);
}

}  // namespace grus::app
