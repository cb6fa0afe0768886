// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/section.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

Vec3 crossing(const Vec3& a, const Vec3& b, double above_a, double above_b) {
  return a + above_a / (above_a - above_b) * (b - a);
}

}  // namespace

FlatMoments moments_of(const FlatPolygon& p) {
  FlatMoments m;
  for (int k = 1; k + 1 < p.corners; ++k) {
    const auto at = [&](int j) { return p.corner[static_cast<std::size_t>(j)]; };
    const Eigen::Vector2d a = at(0), b = at(k), c = at(k + 1), sum = a + b + c;
    const double part = 0.5 * ((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x());
    m.area += part, m.first += part / 3 * sum;
    m.second += part / 12 * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  }
  return m;
}

FlatPolygon clipped(const FlatPolygon& p, const Eigen::Vector2d& along, double offset) {
  FlatPolygon part;
  for (int k = 0; k < p.corners; ++k) {
    const Eigen::Vector2d from = p.corner[static_cast<std::size_t>(k)],
                          to = p.corner[static_cast<std::size_t>(k + 1 < p.corners ? k + 1 : 0)];
    const double a = along.dot(from) - offset, b = along.dot(to) - offset;
    if (a <= 0) part.add(from);
    if ((a < 0 && b > 0) || (a > 0 && b < 0)) part.add(Eigen::Vector2d(from + a / (a - b) * (to - from)));
  }
  return part;
}

FlatPolygon section_of(const HullView& hull, const Vec3& normal, double offset) {
  // The side of the plane that each vertex is on; what is in it counts as below, once for all its edges.
  const std::array<Vec3, 2> e = across(normal);
  const auto above = [&](int v) { return normal.dot(hull.vertex[v]) - offset; };
  FlatPolygon found;
  for (int k = 0; k < hull.edges; ++k) {
    const std::uint8_t* edge = hull.edge + 4 * k;
    const double a = above(edge[0]), b = above(edge[1]);
    if ((a > 0) == (b > 0)) continue;
    const Vec3 x = crossing(hull.vertex[edge[0]], hull.vertex[edge[1]], a, b);
    found.add({e[0].dot(x), e[1].dot(x)});
  }
  if (found.corners < 3) return {};
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (int k = 0; k < found.corners; ++k) middle += found.corner[static_cast<std::size_t>(k)] / found.corners;
  const auto angle = [&](const Eigen::Vector2d& y) { return std::atan2(y.y() - middle.y(), y.x() - middle.x()); };
  std::sort(found.corner.begin(), found.corner.begin() + found.corners,
            [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return angle(a) < angle(b); });
  return found;
}

SolidMoments part_beyond(const HullView& hull, const Vec3& normal, double offset) {
  // Tetrahedra from a point of the plane: its own face adds nothing.
  const Vec3 origin = offset * normal;
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  std::array<Vec3, most_hull_vertices + 2> loop;
  for (int f = 0; f < hull.faces; ++f) {
    std::size_t corners = 0;
    for (int k = hull.begin[f]; k < hull.begin[f + 1]; ++k) {
      const int next = k + 1 < hull.begin[f + 1] ? k + 1 : hull.begin[f];
      const Vec3 from = hull.vertex[hull.loop[k]] - origin, to = hull.vertex[hull.loop[next]] - origin;
      const double a = normal.dot(from), b = normal.dot(to);
      if (a >= 0) loop[corners++] = from;
      if ((a < 0 && b > 0) || (a > 0 && b < 0)) loop[corners++] = crossing(from, to, a, b);
    }
    for (std::size_t k = 1; k + 1 < corners; ++k) {
      const Vec3 &a = loop[0], &b = loop[k], &c = loop[k + 1];
      const double det = a.dot(b.cross(c));
      const Vec3 sum = a + b + c;
      volume += det / 6, first += det / 24 * sum;
      second += det / 120 * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
    }
  }
  if (!(volume > 0)) return {};
  const Vec3 centre = first / volume;
  return {volume, origin + centre, second - volume * centre * centre.transpose()};
}

Polyhedron body_of(const HullView& hull) {
  Polyhedron body;
  body.vertex.assign(hull.vertex, hull.vertex + hull.vertices);
  for (int f = 0; f < hull.faces; ++f)
    body.face.push_back(
        {hull.plane[f].normal, hull.plane[f].offset, f, {hull.loop + hull.begin[f], hull.loop + hull.begin[f + 1]}});
  return body;
}

}  // namespace grus::dem
