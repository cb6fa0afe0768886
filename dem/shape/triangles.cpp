// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/triangles.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

/// As many cubes as triangles, about: each then reaches into few.
constexpr double most_cubes = 4e6;

using Box = std::array<Vec3, 2>;

Box box_of(const Triangles& s, const std::array<Index, 3>& t) {
  const Vec3 &a = s.corner[t[0]], &b = s.corner[t[1]], &c = s.corner[t[2]];
  return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
}

/// The cube that a place lies in along an axis, of those that there are.
Index cube_of(const TriangleGrid& g, double x, int axis) {
  const double at = std::floor((x - g.low[axis]) / g.width);
  const double last = static_cast<double>(g.cubes[static_cast<std::size_t>(axis)] - 1);
  return static_cast<Index>(std::clamp(at, 0.0, last));
}

/// f(cube) of all cubes that a box reaches into.
template <class F>
void each_cube(const TriangleGrid& g, const Box& box, F&& f) {
  std::array<Index, 3> from, to;
  for (int k = 0; k < 3; ++k) {
    from[static_cast<std::size_t>(k)] = cube_of(g, box[0][k], k);
    to[static_cast<std::size_t>(k)] = cube_of(g, box[1][k], k);
  }
  for (Index z = from[2]; z <= to[2]; ++z)
    for (Index y = from[1]; y <= to[1]; ++y)
      for (Index x = from[0]; x <= to[0]; ++x) f((z * g.cubes[1] + y) * g.cubes[0] + x);
}

/// Cubes of the mean width of the triangles, or wider where there would be too many.
void lay_grid(Triangles& s) {
  TriangleGrid& g = s.grid;
  Box whole = box_of(s, s.triangle.front());
  double width = 0;
  for (const auto& t : s.triangle) {
    const Box box = box_of(s, t);
    whole = {whole[0].cwiseMin(box[0]), whole[1].cwiseMax(box[1])};
    width += (box[1] - box[0]).maxCoeff();
  }
  g.low = whole[0], g.width = width / static_cast<double>(s.triangle.size());
  const auto cubes = [&](int k) { return std::floor((whole[1][k] - whole[0][k]) / g.width) + 1; };
  while (cubes(0) * cubes(1) * cubes(2) > most_cubes) g.width *= 1.26;
  for (int k = 0; k < 3; ++k) g.cubes[static_cast<std::size_t>(k)] = static_cast<Index>(cubes(k));
  g.first.assign(std::size_t{g.cubes[0]} * g.cubes[1] * g.cubes[2] + 1, 0);
  for (const auto& t : s.triangle) each_cube(g, box_of(s, t), [&](Index c) { ++g.first[c + 1]; });
  for (std::size_t c = 0; c + 1 < g.first.size(); ++c) g.first[c + 1] += g.first[c];
  g.entry.resize(g.first.back());
  std::vector<Index> next(g.first.begin(), g.first.end() - 1);
  for (std::size_t t = 0; t < s.triangle.size(); ++t)
    each_cube(g, box_of(s, s.triangle[t]), [&](Index c) { g.entry[next[c]++] = static_cast<Index>(t); });
}

}  // namespace

Triangles surface_of(std::vector<Vec3> corner, const std::vector<std::array<Index, 3>>& triangles) {
  Triangles s{.corner = std::move(corner), .triangle = {}, .grid = {}};
  for (const auto& t : triangles) {
    const Vec3 ab = s.corner[t[1]] - s.corner[t[0]], ac = s.corner[t[2]] - s.corner[t[0]];
    if (ab.cross(ac).norm() > 1e-12 * std::max(ab.squaredNorm(), ac.squaredNorm())) s.triangle.push_back(t);
  }
  if (!s.triangle.empty()) lay_grid(s);
  return s;
}

bool sound_surface(const Triangles& s) {
  const bool corners = std::all_of(s.corner.begin(), s.corner.end(), [](const Vec3& x) { return x.allFinite(); });
  return corners && !s.triangle.empty() && !s.grid.first.empty() &&
         std::all_of(s.triangle.begin(), s.triangle.end(), [&](const auto& t) {
           return std::all_of(t.begin(), t.end(), [&](Index c) { return c < s.corner.size(); });
         });
}

Vec3 nearest_on(const Triangles& surface, Index t, const Vec3& x) {
  // By the regions of the plane that belong to corners, edges and the inside (Ericson 2005, 5.1.5).
  const auto& corners = surface.triangle[t];
  const Vec3 &a = surface.corner[corners[0]], &b = surface.corner[corners[1]], &c = surface.corner[corners[2]];
  const Vec3 ab = b - a, ac = c - a, ax = x - a, bx = x - b, cx = x - c;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  // Inside: along the normal, which is more exact than by the parts of the area.
  const Vec3 n = ab.cross(ac).normalized();
  return x - n.dot(ax) * n;
}

void triangles_near(const Triangles& surface, const Vec3& x, double reach, std::vector<Index>& found) {
  found.clear();
  const Vec3 around = Vec3::Constant(reach);
  const TriangleGrid& g = surface.grid;
  const Vec3 high = g.low + g.width * Vec3(g.cubes[0], g.cubes[1], g.cubes[2]);
  if (((x + around).array() < g.low.array()).any() || ((x - around).array() > high.array()).any()) return;
  each_cube(g, {x - around, x + around}, [&](Index c) {
    for (Index e = g.first[c]; e < g.first[c + 1]; ++e)
      if ((nearest_on(surface, g.entry[e], x) - x).squaredNorm() <= reach * reach) found.push_back(g.entry[e]);
  });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
}

}  // namespace grus::dem
