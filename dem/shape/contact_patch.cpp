// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/contact_patch.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace grus::dem {
namespace {

constexpr std::size_t most_corners = most_hull_vertices + most_hull_faces;

struct Polygon {
  std::array<Vec3, most_corners> corner;
  std::size_t corners = 0;
};

/// What of `p` is below a plane, into `to`; false: nothing is beyond it, and `to` is as it was.
bool clip(const Polygon& p, const Plane& plane, Polygon& to) {
  std::array<double, most_corners> above;
  bool beyond = false;
  for (std::size_t k = 0; k < p.corners; ++k)
    beyond = (above[k] = plane.normal.dot(p.corner[k]) - plane.offset) > 0 || beyond;
  if (!beyond) return false;
  to.corners = 0;
  for (std::size_t k = 0; k < p.corners; ++k) {
    const std::size_t next = k + 1 < p.corners ? k + 1 : 0;
    if (above[k] <= 0) to.corner[to.corners++] = p.corner[k];
    if ((above[k] <= 0) != (above[next] <= 0))
      to.corner[to.corners++] = p.corner[k] + above[k] / (above[k] - above[next]) * (p.corner[next] - p.corner[k]);
  }
  return true;
}

/// The plane that `middle` is nearest to, or highest above: most of a body that touches is above it. None: of no
/// planes.
const Plane* nearest_to(const Vec3& middle, std::span<const Plane> planes) {
  double highest = -INFINITY;
  const Plane* nearest = nullptr;
  for (const Plane& plane : planes)
    if (const double height = plane.normal.dot(middle) - plane.offset; height > highest)
      highest = height, nearest = &plane;
  return nearest;
}

/// A circle that holds all corners.
struct Circle {
  Vec3 centre = Vec3::Zero();
  double radius = 0;

  explicit Circle(const Polygon& p) {
    for (std::size_t k = 0; k < p.corners; ++k) centre += p.corner[k];
    centre /= static_cast<double>(p.corners);
    double most = 0;
    for (std::size_t k = 0; k < p.corners; ++k) most = std::max(most, (p.corner[k] - centre).squaredNorm());
    radius = (1 + 1e-12) * std::sqrt(most);
  }
  bool is_below(const Plane& plane) const { return plane.normal.dot(centre) + radius < plane.offset; }
};

}  // namespace

Mat3 turning_of_patch(const HullView& a, std::span<const Plane> planes, const Vec3& middle) {
  Mat3 second = Mat3::Zero();
  const Plane* const nearest = nearest_to(middle, planes);
  std::array<bool, most_hull_vertices> above{};
  for (std::size_t v = 0; nearest && v < static_cast<std::size_t>(a.vertices); ++v)
    above[v] = nearest->normal.dot(a.vertex[v]) - nearest->offset > 0;
  const auto gone = [&](std::uint8_t v) { return above[v]; };  // nothing of a face is left whose vertices all are
  std::array<Polygon, 2> room;
  for (int f = 0; f < a.faces; ++f) {
    if (std::all_of(a.loop + a.begin[f], a.loop + a.begin[f + 1], gone)) continue;
    Polygon *now = &room[0], *next = &room[1];
    now->corners = 0;
    for (int k = a.begin[f]; k < a.begin[f + 1]; ++k) now->corner[now->corners++] = a.vertex[a.loop[k]];
    if (nearest && clip(*now, *nearest, *next)) std::swap(now, next);
    if (now->corners < 3) continue;
    const Circle small(*now);  // of little overlap: most planes do not come near
    for (const Plane& plane : planes) {
      if (now->corners < 3) break;
      if (&plane != nearest && !small.is_below(plane) && clip(*now, plane, *next)) std::swap(now, next);
    }
    if (now->corners < 3) continue;
    const Vec3 first = now->corner[0] - middle;
    Vec3 before = now->corner[1] - middle;
    for (std::size_t k = 2; k < now->corners; ++k) {
      const Vec3 after = now->corner[k] - middle, sum = first + before + after;
      const double part = 0.5 * a.plane[f].normal.dot((before - first).cross(after - first));
      second +=
          part / 12 *
          (sum * sum.transpose() + first * first.transpose() + before * before.transpose() + after * after.transpose());
      before = after;
    }
  }
  return second.trace() * Mat3::Identity() - second;
}

}  // namespace grus::dem
