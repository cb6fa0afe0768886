// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/wall_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "apps/scene/bodies_scene.hpp"
#include "apps/scene/packing_scene.hpp"
#include "apps/scene/sample_scene.hpp"
#include "apps/scene/speeds.hpp"
#include "dem/packing/surfaces.hpp"

namespace grus::app {
namespace {

using dem::Index;
using dem::Vec3;

constexpr std::size_t most_triangles = 10'000'000;
constexpr const char* surface_endings[] = {".stl", ".obj", ".ply"};

dem::WallShape read_plane(Table& t, const Vec3&) {
  for (const char* key : {"axis", "radius"})
    if (t.has(key)) t.fail(key, "is for shape = \"cylinder\"");
  Vec3 normal = vector3(t.numbers("normal", 3, dimension::none));
  if (!(normal.norm() > 0)) t.fail("normal", "must not be zero");
  if (std::abs(normal.norm() - 1) > 1e-12) normal.normalize();
  return dem::PlaneWall{normal};
}

dem::WallShape read_round(Table& t, const Vec3& velocity) {
  if (t.has("normal")) t.fail("normal", "of a cylinder is everywhere towards its axis; give axis and radius");
  dem::CylinderWall round;
  round.radius = t.number("radius", dimension::length, positive);
  round.axis[t.choice("axis", {"x", "y", "z"})[0] - 'x'] = 1;
  if (!(velocity - round.axis.dot(velocity) * round.axis).isZero(0))
    t.fail("velocity", "a cylinder moves along its axis alone");
  return round;
}

/// A kind of file that holds surfaces, by its ending.
bool has_triangles(std::string path) {
  std::transform(path.begin(), path.end(), path.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::any_of(std::begin(surface_endings), std::end(surface_endings),
                     [&](const char* ending) { return path.ends_with(ending); });
}

/// The surface of a file, about the wall's point.
dem::WallShape read_mesh(Table& t) {
  for (const char* key : {"normal", "axis", "radius"})
    if (t.has(key)) t.fail(key, "is of other shapes: a mesh has its triangles");
  const double unit = read_unit(t);
  const std::string path = t.path("path");
  if (!has_triangles(path)) t.fail("path", "a wall is read from a file that ends with .stl, .obj or .ply");
  std::vector<Vec3> corner;
  std::vector<std::array<Index, 3>> triangle;
  try {
    for (const dem::Surface& s : dem::read_surfaces(path)) {
      const auto first = static_cast<Index>(corner.size());
      for (const Vec3& x : s.corner) corner.emplace_back(unit * x);
      for (const auto& face : s.face)
        for (std::size_t k = 2; k < face.size(); ++k)
          triangle.push_back({first + static_cast<Index>(face[0]), first + static_cast<Index>(face[k - 1]),
                              first + static_cast<Index>(face[k])});
    }
  } catch (const InputError& e) {
    t.fail("path", e.what());
  }
  dem::Triangles surface = dem::surface_of(std::move(corner), triangle);
  if (surface.triangle.empty()) t.fail("path", "no triangles in it that have an area");
  if (surface.triangle.size() > most_triangles) t.fail("path", "more than ten million triangles");
  return dem::MeshWall{std::make_shared<dem::Triangles>(std::move(surface))};
}

dem::WallShape read_shape(Table& t, const Vec3& velocity) {
  const std::string shape = t.choice_or("shape", "plane", {"plane", "cylinder", "mesh"});
  for (const char* key : {"path", "unit"})
    if (shape != "mesh" && t.has(key)) t.fail(key, "is for shape = \"mesh\"");
  if (shape == "mesh") return read_mesh(t);
  return shape == "plane" ? read_plane(t, velocity) : read_round(t, velocity);
}

bool names_material(const Table& t) { return t.has("material") || t.has("rigid") || t.has("friction"); }

std::uint8_t read_material(Table& t, RveScene& scene) {
  const bool rigid = t.flag_or("rigid", !t.has("material"));
  if (rigid && t.has("material")) t.fail("rigid", "a wall is either rigid or of a material");
  if (!rigid && t.has("friction")) t.fail("friction", "a wall of a material has that material's friction");
  if (!rigid && !t.has("material")) t.fail("", "needs material, or rigid = true");
  return rigid ? rigid_material(t, scene.model, t.number_or("friction", NAN, dimension::none, not_negative))
               : material_of(t, scene.model, t.text("material"));
}

/// What a plane that faces along `normal` is to press with; `area`: what it presses on (m^2), 0 of a box's own.
void read_control(Table& t, std::size_t wall, const Vec3& normal, const Vec3& velocity, RveScene& scene) {
  const bool pressing = t.choice_or("control", "velocity", {"velocity", "stress"}) == "stress";
  for (const char* key : {"stress", "stress_rate", "area", "max_speed"})
    if (!pressing && t.has(key)) t.fail(key, "is for control = \"stress\"");
  if (!pressing) return;
  if (std::abs(normal.dot(velocity)) > 1e-12 * velocity.norm())
    t.fail("velocity", "of a wall that seeks a stress is along its plane: the stress decides how it goes across");
  dem::WallControl control{.wall = wall};
  control.stress = t.number("stress", dimension::pressure, not_negative);
  refuse_high_pressure(t, "stress", control.stress, scene.model);
  control.stress_rate = t.number_or("stress_rate", 0, dimension::stress_rate, any);
  if (t.has("side")) {
    if (t.has("area")) t.fail("area", "of a side is that of the box there");
  } else {
    control.area = t.number("area", dimension::area, positive);
  }
  if (t.has("max_speed")) {
    control.max_speed = t.number("max_speed", dimension::speed, positive);
    refuse_fast(t, "max_speed", control.max_speed, scene.model);
  }
  scene.test.loading.walls.push_back(control);
}

/// A material of the same grains that move with a wall: nothing damps or breaks them.
std::uint8_t fixed_material(const Table& t, std::size_t of, dem::Model& model) {
  dem::Material m = model.materials[of];
  m.name += fmt::format("-fixed-{}", model.materials.size());
  m.fixed = true, m.damping = 0, m.fracture.reset();
  return add_material(t, model, m);
}

/// The grains that move with a wall and make it rough.
void read_rough(Table& t, std::size_t wall, RveScene& scene) {
  const bool layer = t.has("fixed_layer"), named = t.has("fixed_material");
  if (!layer && !named) return;
  const char* const key = layer ? "fixed_layer" : "fixed_material";
  dem::RoughWall rough{.wall = wall, .place = t.place(key)};
  if (layer) rough.within = t.number("fixed_layer", dimension::length, positive);
  if (named) rough.of = material_of(t, scene.model, t.text("fixed_material"), "fixed_material");
  dem::Model& model = scene.model;
  if (scene.recipe.of_voronoi())
    t.fail(key, "is of loose grains: Voronoi cells are held by [[clamp]] or boundary.bonded");
  if (model.stepper != &dem::explicit_stepper) t.fail(key, "needs explicit steps, not numerics.engine = \"implicit\"");
  if (model.numerics.inertia_step > 0) t.fail(key, "cannot be with numerics.inertia.step");
  const std::size_t own = model.materials.size();
  for (std::size_t m = 0; m < own; ++m) {
    const bool any = std::isfinite(model.materials[m].youngs_modulus) && !model.materials[m].fixed;
    const bool wanted = any && m == rough.of.value_or(static_cast<std::uint8_t>(m));
    rough.becomes.push_back(wanted ? fixed_material(t, m, model) : static_cast<std::uint8_t>(m));
  }
  scene.recipe.rough.push_back(rough);
}

const std::vector<std::string> sides{"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"};

void read_side(Table& t, RveScene& scene) {
  for (const char* key : {"point", "normal", "shape", "axis", "radius", "path", "unit"})
    if (t.has(key)) t.fail(key, "is of walls without side: the box says where a side is");
  const std::string name = t.choice("side", sides);
  const auto place = static_cast<std::size_t>(std::find(sides.begin(), sides.end(), name) - sides.begin());
  const bool plates = scene.recipe.between_plates();  // alone: the first two walls are those across z
  if (!scene.recipe.has_sides()) t.fail("side", "needs boundary.kind = \"walls\", \"cylinder\" or \"periodic-xy\"");
  if (plates && place < 4) t.fail("side", "of a cylinder or of \"periodic-xy\" is \"zmin\" or \"zmax\"");
  auto& others = scene.recipe.sides;
  if (std::any_of(others.begin(), others.end(), [&](const dem::Side& s) { return s.name == name; }))
    t.fail("side", "is given twice");
  dem::Side side{.name = name};
  side.velocity = read_velocity(t, scene.model);
  const std::size_t wall = plates ? place - 4 : place;
  const auto& controls = scene.test.loading.walls;
  const std::size_t opposite = wall ^ 1u, before = controls.size();
  const bool pressed =
      std::any_of(controls.begin(), controls.end(), [&](const dem::WallControl& c) { return c.wall == opposite; });
  read_control(t, wall, Vec3::Unit(static_cast<int>(place / 2)), side.velocity, scene);
  if (pressed && controls.size() > before)
    t.fail("control",
           "the side opposite seeks a stress, too: nothing would hold the sample between them; use "
           "loading.kind = \"true-triaxial\", or hold one");
  if (names_material(t)) side.material = read_material(t, scene);
  read_rough(t, wall, scene);
  others.push_back(side);
}

}  // namespace

void read_wall(Table t, RveScene& scene) {
  if (t.has("side")) {
    read_side(t, scene);
    return t.finish();
  }
  dem::OwnWall own{.place = t.place(""), .place_of_normal = t.place("normal")};
  dem::Wall& wall = own.wall;
  wall.point = vector3(t.numbers("point", 3, dimension::length));
  wall.velocity = read_velocity(t, scene.model);
  wall.shape = read_shape(t, wall.velocity);
  const auto round = [](const dem::OwnWall& w) { return std::holds_alternative<dem::CylinderWall>(w.wall.shape); };
  const auto& others = scene.recipe.walls;
  if (round(own) && std::any_of(others.begin(), others.end(), round))
    t.fail("shape", "a scene has one cylinder at most");
  const bool plane = std::holds_alternative<dem::PlaneWall>(wall.shape);
  for (const char* key : {"control", "fixed_layer", "fixed_material"})
    if (!plane && t.has(key)) t.fail(key, "is of planes");
  if (plane) read_control(t, others.size(), wall.facing(), wall.velocity, scene);
  wall.material = read_material(t, scene);
  read_rough(t, others.size(), scene);
  scene.recipe.walls.push_back(own);
  t.finish();
}

void refuse_own_motion(const Table& t, const std::string& key, const RveScene& scene) {
  const dem::Recipe& r = scene.recipe;
  const auto moves = [](const dem::Vec3& velocity) { return !velocity.isZero(0); };
  const bool some = std::any_of(r.sides.begin(), r.sides.end(), [&](const auto& s) { return moves(s.velocity); }) ||
                    std::any_of(r.walls.begin(), r.walls.end(), [&](const auto& w) { return moves(w.wall.velocity); });
  if (!some && scene.test.loading.walls.empty()) return;
  t.fail(key,
         "walls that move by themselves ([[wall]] with velocity, or control = \"stress\") need loading.kind = "
         "\"free\"");
}

}  // namespace grus::app
