// SPDX-License-Identifier: LGPL-3.0-or-later
// [[grain]], [[wall]] and [boundary]: what is there at the start; [packing] is in packing_scene.cpp.
#include "apps/scene/sample_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include <set>

#include "apps/scene/hulls_scene.hpp"
#include "apps/scene/packing_scene.hpp"
#include "apps/scene/supports_scene.hpp"
#include "dem/rve/measure.hpp"
#include "dem/state/shape_kinds.hpp"

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
  if (model.materials.size() > most_materials)
    at.fail("", fmt::format("more than {} materials, those of walls with different friction counted", most_materials));
  model.materials.push_back(m);
  return static_cast<std::uint8_t>(model.materials.size() - 1);
}

namespace {

void read_grain(Table t, RveScene& scene) {
  dem::GrainSpec spec;
  const std::string shape = t.choice_or("shape", "sphere", {"sphere", "polyellipsoid", "hull"});
  const std::string name = t.text_or("material", scene.model.materials.front().name);
  spec.material = material_of(t, scene.model, name);
  const dem::Material& material = scene.model.materials[spec.material];
  spec.density = material.density;
  spec.turns = material.turns;
  if (shape == "sphere") {
    const double radius = t.number("radius", dimension::length, positive);
    check_mass(t, material, radius, "radius");
    spec.shape = dem::PolyEllipsoid::sphere(radius);
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
  spec.velocity = vector3(t.numbers_or("velocity", {0, 0, 0}, dimension::speed));
  spec.spin = vector3(t.numbers_or("spin", {0, 0, 0}, dimension::rate));
  if (!spec.turns && !spec.spin.isZero())
    t.fail("spin", fmt::format("material.{}.rotation = false: its grains do not turn", material.name));
  const auto q = t.numbers_or("orientation", {1, 0, 0, 0}, dimension::none);
  spec.orientation = dem::Quat(q[0], q[1], q[2], q[3]);
  if (std::abs(spec.orientation.norm() - 1) > 1e-3) t.fail("orientation", "must be a unit quaternion w, x, y, z");
  if (shape == "hull") {
    read_hull(t, scene.state.grains, spec, scene.notes);
    const double radius = scene.state.grains.hulls->row[*spec.hull].bounding_radius;
    check_mass(t, material, radius, t.has("box") ? "box" : "vertices");
  } else {
    spec.inertia = scene.model.numerics.inertia_factor(dem::equivalent_radius(spec.shape));
  }
  dem::set_grain(scene.state.grains, scene.state.grains.size(), spec);
  t.finish();
}

void read_plane(Table& t, dem::Wall& wall) {
  for (const char* key : {"axis", "radius"})
    if (t.has(key)) t.fail(key, "is for shape = \"cylinder\"");
  wall.normal = vector3(t.numbers("normal", 3, dimension::none));
  if (!(wall.normal.norm() > 0)) t.fail("normal", "must not be zero");
  if (std::abs(wall.normal.norm() - 1) > 1e-12) wall.normal.normalize();
}

void read_round(Table& t, dem::Wall& wall) {
  if (t.has("normal")) t.fail("normal", "of a cylinder is everywhere towards its axis; give axis and radius");
  wall.normal.setZero();
  wall.radius = t.number("radius", dimension::length, positive);
  wall.axis.setZero();
  wall.axis[t.choice("axis", {"x", "y", "z"})[0] - 'x'] = 1;
  if (!(wall.velocity - wall.axis.dot(wall.velocity) * wall.axis).isZero(0))
    t.fail("velocity", "a cylinder moves along its axis alone");
}

void read_wall(Table t, RveScene& scene) {
  dem::Wall wall;
  wall.point = vector3(t.numbers("point", 3, dimension::length));
  wall.velocity = vector3(t.numbers_or("velocity", {0, 0, 0}, dimension::speed));
  (t.choice_or("shape", "plane", {"plane", "cylinder"}) == "plane" ? read_plane : read_round)(t, wall);
  if (wall.round() && dem::cylinder(scene.state.boundary)) t.fail("shape", "a scene has one cylinder at most");
  const bool rigid = t.flag_or("rigid", !t.has("material"));
  if (rigid && t.has("material")) t.fail("rigid", "a wall is either rigid or of a material");
  if (!rigid && t.has("friction")) t.fail("friction", "a wall of a material has that material's friction");
  if (!rigid && !t.has("material")) t.fail("", "needs material, or rigid = true");
  wall.material = rigid ? rigid_material(t, scene.model, t.number_or("friction", NAN, dimension::none, not_negative))
                        : material_of(t, scene.model, t.text("material"));
  scene.state.boundary.walls.push_back(wall);
  t.finish();
}

/// The last wall against those before it and against the grains: each would press on what is behind it.
void check_wall(const Table& t, const RveScene& scene) {
  const auto& walls = scene.state.boundary.walls;
  const dem::Wall& last = walls.back();
  if (last.round()) return;
  const dem::Grains& g = scene.state.grains;
  double size = 0;
  for (const auto& extent : g.extent) size = std::max(size, extent.equivalent_radius);
  for (std::size_t k = 0; k + 1 < walls.size(); ++k) {
    if (walls[k].round()) continue;
    const double along = walls[k].normal.dot(last.normal), ahead = last.normal.dot(walls[k].point - last.point);
    if (along > 1 - 1e-9 && std::abs(ahead) <= 1e-9 * size)
      t.fail("", fmt::format("this wall is where wall {} is: together they would be twice as stiff; leave one out", k));
    if (along < -1 + 1e-9 && ahead < 0)
      t.fail("normal", fmt::format("no place is on the inner side of both this wall and wall {}: turn one of them", k));
  }
  for (std::size_t i = 0; i < g.size(); ++i)
    if (last.normal.dot(g.motion[i].position - last.point) < 0)
      t.fail("normal", fmt::format("grain {} is behind this wall: its normal points to where grains may be", i));
}

void add_box_walls(const Vec3& box, std::uint8_t material, dem::Boundary& boundary) {
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

/// Two plates, and a cylinder of the box's width about its middle.
void add_cylinder_walls(const Vec3& box, std::uint8_t material, dem::Boundary& boundary) {
  for (int side = 0; side < 2; ++side)
    boundary.walls.push_back({.point = Vec3(0, 0, side ? box[2] : 0),
                              .normal = Vec3(0, 0, side ? -1 : 1),
                              .material = material,
                              .name = side ? "zmax" : "zmin"});
  boundary.walls.push_back({.point = Vec3(0.5 * box[0], 0.5 * box[0], 0),
                            .normal = Vec3::Zero(),
                            .material = material,
                            .name = "cylinder",
                            .axis = Vec3::UnitZ(),
                            .radius = 0.5 * box[0]});
}

/// What is for spheres alone has no other grains, and none that halves would make.
void refuse_shapes(const Table& t, const RveScene& scene, const std::string& why) {
  const auto& kinds = scene.state.grains.kind;
  if (std::find(kinds.begin(), kinds.end(), dem::ShapeKind::polyellipsoid) != kinds.end())
    t.fail("grain", why + " needs a scene of spheres alone");
  for (const auto& m : scene.model.materials)
    if (m.fracture && std::holds_alternative<dem::Halves>(m.fracture->splitter))
      t.fail("material", fmt::format("{} needs spheres alone, which fragments of \"polyellipsoid-split\" ({}) are not; "
                                     "use \"apollonian-14\"",
                                     why, m.name));
}

/// Bonds are made between packed cells and between the parts of a grain that cleaves; elsewhere nobody would read the
/// table.
void refuse_unbonded(const Table& t, const RveScene& scene) {
  if (scene.cells) return;
  for (const auto& m : scene.model.materials)
    if (m.bond && !(m.fracture && std::holds_alternative<dem::Cut>(m.fracture->splitter)))
      t.fail("material",
             fmt::format("{}.bond: bonds are made between the cells of packing.kind \"voronoi\" or \"prisms\"; "
                         "nothing is bonded here: leave the table out",
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
void tell_unused(RveScene& scene, std::size_t own) {
  std::set<std::string> names;
  named_materials(scene.record, names);
  for (std::size_t i = 1; i < own; ++i)  // the first is everybody's who names none
    if (const std::string& name = scene.model.materials[i].name; !names.contains(name))
      scene.notes.push_back(fmt::format("material.{}: no grain and no wall is of it", name));
}

/// A grain that its material's splitter can make nothing of would never break.
void refuse_unsplit(const Table& t, const RveScene& scene) {
  const dem::Grains& g = scene.state.grains;
  for (std::size_t i = 0; i < g.size(); ++i) {
    const auto& fracture = scene.model.materials[g.material[i]].fracture;
    if (fracture && std::holds_alternative<dem::Balls>(fracture->splitter) && !dem::is_sphere(g, i))
      t.fail("grain", fmt::format("grain {} is no sphere: \"apollonian-14\" splits spheres", i));
  }
}

}  // namespace

void read_sample(Table& t, RveScene& scene) {
  dem::Boundary& boundary = scene.state.boundary;
  const std::size_t own = scene.model.materials.size();  // before rigid walls
  std::string kind = "open";
  double friction = NAN;
  std::string wall_material;
  std::optional<Table> b = t.table_if("boundary");
  if (b) {
    kind = b->choice("kind", {"walls", "cylinder", "periodic", "open"});
    if (kind == "walls" || kind == "cylinder") {
      if (b->has("material"))
        wall_material = b->text("material");
      else
        friction = b->number_or("friction", NAN, dimension::none, not_negative);
    }
  }
  if (kind == "periodic") boundary.cell.vectors.setIdentity();  // sized by the packing below
  Vec3 box = Vec3::Zero();
  const auto grains = t.tables("grain");
  if (auto p = t.table_if("packing")) {
    if (!grains.empty()) t.fail("packing", "a scene has either [packing] or [[grain]]");
    read_packing(*p, scene, kind == "cylinder", box);
  }
  for (const auto& g : grains) read_grain(g, scene);
  scene.listed_grains = grains.size();
  if (!grains.empty() && scene.scale != 1) t.fail("grain", "loading.scale is for random packings");
  const std::vector<Table> walls = t.tables("wall");
  for (const Table& w : walls) {
    if (kind == "periodic") w.fail("", "a periodic cell has no walls");
    read_wall(w, scene);
    check_wall(w, scene);
  }
  if (scene.grains() == 0) t.fail("", "the scene has no grains: give [packing] or [[grain]]");
  if (kind != "open" && box.isZero()) {
    if (!b->has("box")) b->fail("box", "needs the size of the box: boundary.box, or packing.box");
    box = vector3(b->numbers("box", 3, dimension::length));
    if (!(box.minCoeff() > 0)) b->fail("box", "all three sides must be above 0");
    if (kind == "cylinder") check_cylinder(*b, box);
  }
  if (kind == "periodic") {
    boundary.cell.vectors = dem::Mat3(box.asDiagonal());
    for (std::size_t i = 0; i < scene.listed_grains; ++i)
      if (!(scene.state.grains.motion[i].position.cwiseQuotient(box).cwiseAbs().maxCoeff() < 1000))
        t.fail("grain", fmt::format("grain {} lies more than a thousand cells away from the cell at the origin", i));
  }
  if (kind == "walls" || kind == "cylinder") {
    if (!boundary.walls.empty())
      b->fail("kind", fmt::format("\"{}\" makes its own walls; use \"open\" with [[wall]]", kind));
    (kind == "walls" ? add_box_walls : add_cylinder_walls)(
        box,
        wall_material.empty() ? rigid_material(*b, scene.model, friction) : material_of(*b, scene.model, wall_material),
        boundary);
  }
  if (b && kind == "walls") glue_to_walls(*b, scene);
  if (b) b->finish();
  const auto held = std::find_if(scene.model.materials.begin(), scene.model.materials.end(),
                                 [](const dem::Material& m) { return !m.turns; });
  if (held != scene.model.materials.end())
    refuse_shapes(t, scene, fmt::format("material.{}.rotation = false", held->name));
  if (dem::cylinder(boundary)) refuse_shapes(t, scene, "a cylinder");
  if (dem::attracts(scene.model.law)) refuse_shapes(t, scene, "a contact law with attraction");
  refuse_unsplit(t, scene);
  refuse_unbonded(t, scene);
  tell_unused(scene, own);
  check_hulls(t, scene);
  // Impossible starts are refused, not pushed apart: their energy would be nobody's.
  dem::update_frames(scene.state.grains);
  for (std::size_t i = 0; i < scene.listed_grains; ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (scene.state.grains.motion[i].position == scene.state.grains.motion[j].position)
        t.fail("grain", fmt::format("grains {} and {} have the same centre", j, i));
}

void add_platens(const Table& at, RveScene& scene, int axis, double speed, double friction) {
  double low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < scene.state.grains.size(); ++i) {
    Vec3 up = Vec3::Zero();
    up[axis] = 1;
    const double x = scene.state.grains.motion[i].position[axis];
    high = std::max(high, x + dem::surface_arm(scene.state.grains, i, up)[axis]);
    low = std::min(low, x + dem::surface_arm(scene.state.grains, i, -up)[axis]);
  }
  const auto material = rigid_material(at, scene.model, friction);
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
