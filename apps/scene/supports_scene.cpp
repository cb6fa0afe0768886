// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/supports_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include "apps/scene/sample_scene.hpp"

namespace grus::app {
namespace {

using dem::Vec3;

constexpr int roller_corners = 32;
constexpr double least_stiffer = 0.02;  // a mesh differs by as much from another

/// "x=min": the direction outwards.
Vec3 direction_of(Table& t) {
  const std::string where = t.choice("where", {"x=min", "x=max", "y=min", "y=max", "z=min", "z=max"});
  Vec3 d = Vec3::Zero();
  d[where[0] - 'x'] = where.substr(2) == "min" ? -1 : 1;
  return d;
}

std::vector<dem::OuterFace> faces_of(Table& t, const RveScene& scene, const Vec3& direction, double& offset) {
  if (!scene.cells) t.fail("", "needs cells to hold on to: packing.kind = \"voronoi\"");
  auto faces = dem::faces_towards(scene.cells->faces.outer, direction, offset);
  if (faces.empty()) t.fail("where", "the cells have no flat end there");
  return faces;
}

/// One cell alone has no bond, and yet holds on to what it is glued to.
bool holds_on(const RveScene& scene) {
  if (!scene.cells || scene.cells->faces.outer.empty()) return false;
  const dem::Index cell = scene.cells->faces.outer.front().grain;
  return scene.model.materials[scene.state.grains.material[cell]].bond.has_value();
}

/// Few cells between plane faces are stiffer than the `modulus` of their bonds, which is that of many.
void note_stiffness(RveScene& scene, int axis) {
  const auto& bond = scene.model.materials[scene.state.grains.material[0]].bond;
  const double more = bond ? dem::stiffer_than_endless(scene.state, *bond, axis) - 1 : 0;
  if (std::abs(more) < least_stiffer) return;
  scene.notes.push_back(
      fmt::format("along {} these cells are some {:.0f} % {} than bond.modulus, which is that of many cells: next to a "
                  "plane face they "
                  "line up with it (docs/bonded.md); take more cells, or calibrate modulus with these",
                  "xyz"[axis], 100 * std::abs(more), more > 0 ? "stiffer" : "softer"));
}

/// Force along its way that the moving one of a test meets, and stress by load.
void measure_pull(RveScene& scene, std::size_t wall, double area) {
  const Vec3& v = scene.state.boundary.walls[wall].velocity;
  scene.cells->gauge = RveScene::Gauge{{{wall, -1.0}}, v.normalized(), wall, 1 / area};
}

void read_clamp(Table t, RveScene& scene) {
  const Vec3 direction = direction_of(t);
  double offset;
  const auto faces = faces_of(t, scene, direction, offset);
  if (!holds_on(scene)) t.fail("", "needs [material.NAME.bond], by which cells hold on");
  dem::Wall wall;
  wall.point = offset * direction, wall.normal = -direction;
  for (const dem::Wall& other : scene.state.boundary.walls)
    if (other.normal == wall.normal) t.fail("where", "is clamped twice");
  const auto v = t.numbers_or("velocity", {0, 0, 0}, dimension::speed);
  wall.velocity = {v[0], v[1], v[2]};
  wall.material = rigid_material(t, scene.model, NAN);
  scene.state.boundary.walls.push_back(wall);
  const std::size_t at = scene.state.boundary.walls.size() - 1;
  dem::glue(scene.model, faces, static_cast<dem::Index>(at), t.flag_or("slides", false), scene.state);
  double area = 0;
  for (const auto& f : faces) area += f.face.area;
  if (!wall.velocity.isZero(0)) measure_pull(scene, at, area);
  t.finish();
}

void read_load(Table t, RveScene& scene) {
  double offset;
  const auto faces = faces_of(t, scene, direction_of(t), offset);
  const auto f = t.numbers("force", 3, dimension::force);
  dem::add_load(faces, {f[0], f[1], f[2]}, t.number_or("ramp", 0, dimension::time, not_negative), scene.state);
  t.finish();
}

/// A prism about an axis, one corner towards `up`.
dem::Index add_roller(dem::Grains& grains, double radius, double length, int axis, const Vec3& up) {
  const Vec3 along = Vec3::Unit(axis), across = along.cross(up);
  std::vector<Vec3> points;
  for (int k = 0; k < roller_corners; ++k) {
    const double angle = 2 * dem::pi * k / roller_corners;
    for (const double end : {-0.5, 0.5})
      points.emplace_back(radius * (std::cos(angle) * up + std::sin(angle) * across) + end * length * along);
  }
  dem::HullStore store = *grains.hulls;
  const dem::Index row = dem::add_unturned(store, dem::hull_of(points));
  grains.hulls = std::make_shared<dem::HullStore>(std::move(store));
  return row;
}

/// Where along an axis, counted outwards from the cells, the middle of a roller at `place` across it touches them
/// first; -infinity where it meets none.
double touching(const dem::Grains& g, double place, double radius, int span, const Vec3& outward) {
  double at = -INFINITY;
  const auto round = [&](double x, double height) {  // a circle about its middle over a point
    if (std::abs(x - place) < radius) at = std::max(at, height + std::sqrt(radius * radius - std::pow(x - place, 2)));
  };
  for (std::size_t i = 0; i < g.size(); ++i) {
    const dem::HullView hull = (*g.hulls)[g.hull[i]];
    const auto corner = [&](int k) { return Vec3(g.motion[i].position + g.orientation[i] * hull.vertex[k]); };
    for (int f = 0; f < hull.faces; ++f)
      for (int k = hull.begin[f]; k < hull.begin[f + 1]; ++k) {
        const Vec3 p = corner(hull.loop[k]), q = corner(hull.loop[k + 1 < hull.begin[f + 1] ? k + 1 : hull.begin[f]]);
        const double x = p[span], y = p.dot(outward), dx = q[span] - x, dy = q.dot(outward) - y, l = std::hypot(dx, dy);
        round(x, y);
        if (!(std::abs(dx) > 1e-9 * l)) continue;
        // Beside an edge: its line moved outwards by the radius.
        const double slope = dy / dx, foot = place + radius * slope / std::hypot(1.0, slope);
        if ((foot - x) * (foot - q[span]) < 0)
          at = std::max(at, y + slope * (place - x) + radius * std::hypot(1.0, slope));
      }
  }
  return at;
}

}  // namespace

void read_supports(Table& t, RveScene& scene) {
  const auto clamps = t.tables("clamp"), loads = t.tables("load");
  const dem::Boundary& boundary = scene.state.boundary;
  if (!clamps.empty() && (boundary.cell.periodic() || !boundary.walls.empty()))
    clamps.front().fail("", "clamps are for open samples: leave out [boundary] and [[wall]], or use boundary.bonded");
  if (!loads.empty() && boundary.cell.periodic()) loads.front().fail("", "a periodic cell has no ends");
  for (const auto& c : clamps) read_clamp(c, scene);
  for (const auto& l : loads) read_load(l, scene);
  if (!scene.state.bonds.wall.empty() && !clamps.empty()) {
    int axis = 0;
    scene.state.boundary.walls.front().normal.cwiseAbs().maxCoeff(&axis);
    note_stiffness(scene, axis);
  }
  if (scene.cells) scene.cells->faces.outer = {};  // nobody else asks
}

void glue_to_walls(Table& t, RveScene& scene) {
  const std::string how = t.choice_or("bonded", "no", {"no", "normal", "full"});
  if (how == "no") return;
  if (!holds_on(scene)) t.fail("bonded", "needs packing.kind = \"voronoi\" and [material.NAME.bond]");
  for (std::size_t w = 0; w < scene.state.boundary.walls.size(); ++w) {
    const Vec3 outward = -scene.state.boundary.walls[w].normal;
    double offset;
    const auto faces = dem::faces_towards(scene.cells->faces.outer, outward, offset);
    const double gap = scene.state.boundary.walls[w].point.dot(outward) - offset;
    if (faces.empty() || std::abs(gap) > 1e-6 * scene.cells->box.maxCoeff())
      t.fail("bonded", fmt::format("no cell touches the wall {}", scene.state.boundary.walls[w].name));
    dem::glue(scene.model, faces, static_cast<dem::Index>(w), how == "normal", scene.state);
  }
}

void read_rollers(Table& t, RveScene& scene) {
  TestProgram& test = scene.test;
  auto& boundary = scene.state.boundary;
  if (boundary.cell.periodic() || !boundary.walls.empty())
    t.fail("kind", "\"rollers\" makes its own; leave out [boundary] and [[wall]]");
  if (!scene.cells || scene.cells->round)
    t.fail("kind", "\"rollers\" bends a box of cells: packing.kind = \"voronoi\"");
  test.axis = t.choice_or("axis", "z", {"x", "y", "z"})[0] - 'x';
  const int span = t.choice_or("span", "x", {"x", "y", "z"})[0] - 'x', third = 3 - test.axis - span;
  if (span == test.axis) t.fail("span", "is across axis");
  const Vec3 box = scene.cells->box;
  const double outer = t.number("outer", dimension::length, {0, box[span], true, true});
  const double inner = t.number_or("inner", 0, dimension::length, {0, outer, false, true});
  const double radius = t.number("radius", dimension::length, positive);
  const double speed = t.number("speed", dimension::speed, positive);
  const auto material = rigid_material(t, scene.model, t.number_or("friction", 0, dimension::none, not_negative));
  RveScene::Gauge gauge;
  gauge.along = -Vec3::Unit(test.axis);
  for (const bool top : {false, true}) {
    const double apart = top ? inner : outer;
    const Vec3 towards = top ? gauge.along : Vec3(-gauge.along);
    const int count = apart > 0 ? 2 : 1;
    const dem::Index hull = add_roller(scene.state.grains, radius, 1.2 * box[third], third, towards);
    for (int k = 0; k < count; ++k) {
      dem::Wall wall;
      wall.normal.setZero();
      wall.point = 0.5 * box;
      wall.point[span] += apart * (0.5 * (count - 1) - k);
      const double height = touching(scene.state.grains, wall.point[span], radius, span, -towards);
      if (!std::isfinite(height)) t.fail(top ? "inner" : "outer", "a roller there would miss the cells");
      wall.point[test.axis] = top ? height : -height;
      if (top) wall.velocity = speed * gauge.along;
      wall.axis = Vec3::Unit(third), wall.roller = radius, wall.hull = hull, wall.material = material;
      gauge.walls.emplace_back(boundary.walls.size(), top ? -0.5 : 0.5);
      gauge.moving = boundary.walls.size();
      boundary.walls.push_back(wall);
    }
  }
  // The beam's fibre stress under the load P: 3 P (outer - inner) / (2 w t^2).
  gauge.stress_per_load = 1.5 * (outer - inner) / (box[third] * box[test.axis] * box[test.axis]);
  scene.cells->gauge = gauge;
  note_stiffness(scene, span);
  test.duration = t.number("final_displacement", dimension::length, positive) / speed;
}

}  // namespace grus::app
