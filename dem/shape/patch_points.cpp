// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/patch_points.hpp"

#include <algorithm>
#include <cmath>

#include "dem/shape/section.hpp"

namespace grus::dem {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr std::size_t most_patch_corners = most_hull_vertices + most_hull_faces;
constexpr double level = 1e-9;     // of a hull's size: vertices so near to the outermost are, too
constexpr double grazing = 1e-3;   // a face that leans so much against the plane across n has no height above it
constexpr double together = 1e-6;  // of the patch: points so near are one

struct Corners {
  std::array<PatchPoint, most_patch_corners> point;
  std::size_t count = 0;

  void add(const PatchPoint& p) {
    if (count < most_patch_corners) point[count++] = p;
  }
};

/// The nearest, and then always the one furthest from all that have been taken.
Patch spread(const Corners& all) {
  Patch patch;
  if (all.count == 0) return patch;
  std::size_t next = 0;
  for (std::size_t k = 1; k < all.count; ++k)
    if (all.point[k].gap < all.point[next].gap) next = k;
  std::array<double, most_patch_corners> far2;
  far2.fill(INFINITY);
  double widest2 = 0;
  while (patch.points < most_patch_points) {
    const PatchPoint taken = all.point[next];
    patch.point[patch.points++] = taken;
    next = 0;
    for (std::size_t k = 0; k < all.count; ++k) {
      far2[k] = std::min(far2[k], (all.point[k].at - taken.at).squaredNorm());
      if (far2[k] > far2[next]) next = k;
    }
    widest2 = std::max(widest2, far2[next]);
    if (!(far2[next] > together * together * widest2)) break;
  }
  return patch;
}

/// The face that ends a hull along d: of those with most of the outermost vertices the one that faces it most.
int outermost_face(const HullView& h, const Vec3& d) {
  const Vec3 top = support(h, d);
  const double slack = level * top.norm(), least = d.dot(top) - slack;
  int best = 0, most = -1;
  double steepest = -INFINITY;
  for (int f = 0; f < h.faces; ++f) {
    int shared = 0;
    for (int k = h.begin[f]; k < h.begin[f + 1]; ++k) shared += d.dot(h.vertex[h.loop[k]]) >= least;
    const double along = d.dot(h.plane[f].normal);
    if (shared == 0 || shared < most || (shared == most && along <= steepest)) continue;
    best = f, most = shared, steepest = along;
  }
  return best;
}

/// A face as it is seen along n, and how high it is there: level + slope . y.
struct Seen {
  std::array<Vec2, most_patch_corners> corner;
  std::size_t corners = 0;
  double height = 0;
  Vec2 slope = Vec2::Zero();

  double at(const Vec2& y) const { return height + slope.dot(y); }
};

/// Corners along the axes e1, e2 across n = e1 x e2. `turn`, `shift`: to the frame in which these are.
Seen seen(const HullView& h, int face, const Mat3& turn, const Vec3& shift, const Vec3& n, const Vec3& e1,
          const Vec3& e2) {
  Seen s;
  const Vec3 normal = turn * h.plane[face].normal;
  for (int k = h.begin[face]; k < h.begin[face + 1]; ++k) {
    const Vec3 x = turn * h.vertex[h.loop[k]] + shift;
    s.corner[s.corners++] = {e1.dot(x), e2.dot(x)};
  }
  const double up = normal.dot(n);
  s.height = (h.plane[face].offset + normal.dot(shift)) / up;
  s.slope = -Vec2(normal.dot(e1), normal.dot(e2)) / up;
  return s;
}

/// What of a polygon is on the left of a line from p to q.
void clip(Seen& of, const Vec2& p, const Vec2& q) {
  const Vec2 along = q - p, left(-along.y(), along.x());
  std::array<Vec2, most_patch_corners> kept;
  std::size_t count = 0;
  for (std::size_t k = 0; k < of.corners && count + 2 <= most_patch_corners; ++k) {
    const Vec2 &x = of.corner[k], &y = of.corner[k + 1 < of.corners ? k + 1 : 0];
    const double dx = left.dot(x - p), dy = left.dot(y - p);
    if (dx >= 0) kept[count++] = x;
    if ((dx > 0 && dy < 0) || (dx < 0 && dy > 0)) kept[count++] = x + dx / (dx - dy) * (y - x);
  }
  of.corner = kept, of.corners = count;
}

}  // namespace

Patch patch_between(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, const Vec3& n,
                    double reach) {
  const Vec3 back = turn.transpose() * n;
  const int of_a = outermost_face(a, n), of_b = outermost_face(b, -back);
  const Vec3 top = support(a, n), low = turn * support(b, -back) + shift;
  const double nearest = n.dot(low - top);
  Corners all;
  if (a.plane[of_a].normal.dot(n) > grazing && -b.plane[of_b].normal.dot(back) > grazing) {
    const Vec3 e1 = n.unitOrthogonal(), e2 = n.cross(e1);
    const Seen face = seen(a, of_a, Mat3::Identity(), Vec3::Zero(), n, e1, e2);
    Seen shared = seen(b, of_b, turn, shift, n, e1, e2);
    for (std::size_t k = 0; k < face.corners; ++k)  // counter-clockwise against n: it faces along it
      clip(shared, face.corner[k], face.corner[k + 1 < face.corners ? k + 1 : 0]);
    for (std::size_t k = 0; k < shared.corners; ++k) {
      const Vec2& y = shared.corner[k];
      const double below = face.at(y), above = shared.at(y);
      if (above - below <= reach) all.add({y.x() * e1 + y.y() * e2 + 0.5 * (below + above) * n, above - below});
    }
  }
  if (all.count == 0 && nearest <= reach) all.add({0.5 * (top + low), nearest});
  return spread(all);
}

Patch patch_on_plane(const HullView& a, const Plane& wall, double reach) {
  Corners all;
  for (int v = 0; v < a.vertices; ++v) {
    const double gap = wall.normal.dot(a.vertex[v]) - wall.offset;
    if (gap <= reach) all.add({a.vertex[v] - 0.5 * gap * wall.normal, gap});
  }
  return spread(all);
}

}  // namespace grus::dem
