// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/supports.hpp"

namespace grus::dem {
namespace {

constexpr int roller_corners = 32;

/// A prism about an axis, one corner towards `up`.
Index add_roller(Grains& grains, double radius, double length, int axis, const Vec3& up) {
  const Vec3 along = Vec3::Unit(axis), across = along.cross(up);
  std::vector<Vec3> points;
  for (int k = 0; k < roller_corners; ++k) {
    const double angle = 2 * pi * k / roller_corners;
    for (const double end : {-0.5, 0.5})
      points.emplace_back(radius * (std::cos(angle) * up + std::sin(angle) * across) + end * length * along);
  }
  HullStore store = *grains.hulls;
  const Index row = add_unturned(store, hull_of(points));
  grains.hulls = std::make_shared<HullStore>(std::move(store));
  return row;
}

/// Where along an axis, counted outwards from the Voronoi cells, the middle of a roller at `place` across it touches
/// them first; -infinity where it meets none.
double touching(const Grains& g, double place, double radius, int span, const Vec3& outward) {
  double at = -INFINITY;
  const auto round = [&](double x, double height) {  // a circle about its middle over a point
    if (std::abs(x - place) < radius) at = std::max(at, height + std::sqrt(radius * radius - std::pow(x - place, 2)));
  };
  for (std::size_t i = 0; i < g.size(); ++i) {
    const HullView hull = (*g.hulls)[g.hull[i]];
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

void put_rollers(const Rollers& r, const Recipe& recipe, Sample& sample) {
  Grains& grains = sample.state.grains;
  auto& walls = sample.state.boundary.walls;
  const Vec3 box = voronoi_box(recipe);
  const int third = 3 - r.axis - r.span;
  Gauge gauge;
  gauge.along = -Vec3::Unit(r.axis);
  for (const bool top : {false, true}) {
    const double apart = top ? r.inner : r.outer;
    const Vec3 towards = top ? gauge.along : Vec3(-gauge.along);
    const int count = apart > 0 ? 2 : 1;
    const Index hull = add_roller(grains, r.radius, 1.2 * box[third], third, towards);
    for (int k = 0; k < count; ++k) {
      Wall wall;
      wall.point = 0.5 * box;
      wall.point[r.span] += apart * (0.5 * (count - 1) - k);
      const double height = touching(grains, wall.point[r.span], r.radius, r.span, -towards);
      if (!std::isfinite(height))
        refuse(top ? r.place_of_inner : r.place_of_outer, "a roller there would miss the Voronoi cells");
      wall.point[r.axis] = top ? height : -height;
      if (top) wall.velocity = r.speed * gauge.along;
      wall.shape = RollerWall{Vec3::Unit(third), r.radius, hull}, wall.material = r.material;
      gauge.walls.emplace_back(walls.size(), top ? -0.5 : 0.5);
      gauge.moving = walls.size();
      walls.push_back(wall);
    }
  }
  // The beam's fibre stress under the load P: 3 P (outer - inner) / (2 w t^2).
  gauge.stress_per_load = 1.5 * (r.outer - r.inner) / (box[third] * box[r.axis] * box[r.axis]);
  sample.gauge = gauge;
}

}  // namespace grus::dem
