// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include "dem/base/error.hpp"
#include "dem/shape/hull_store.hpp"

namespace grus::dem {
namespace {

constexpr double single_precision = 4e-7;  // of how far from the origin a corner is: some units in the last place

/// A polygon of a surface, seen from outside.
struct Facet {
  Vec3 normal, middle;
  double area;
  const std::vector<int>* loop;
};

/// Facets in one plane.
struct MergedFace {
  Vec3 normal, sum, weighted;  // of the first; of areas times normals, and times middles
  double offset, area;

  void settle() {
    normal = sum.normalized();
    offset = normal.dot(weighted) / area;
  }
};

[[noreturn]] void fail(const Surface& s, const std::string& why) { throw InputError(s.name + ": " + why); }

/// Facets by falling area; those narrower than the slack are left out, as their neighbours' planes hold their corners.
std::vector<Facet> facets_of(const Surface& s, const Vec3& inside, double slack) {
  std::vector<Facet> facets;
  for (const auto& loop : s.face) {
    const auto at = [&](std::size_t k) -> const Vec3& { return s.corner[static_cast<std::size_t>(loop[k])]; };
    Vec3 twice = Vec3::Zero(), first = Vec3::Zero();
    double longest = 0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      twice += (at(k) - at(0)).cross(at((k + 1) % loop.size()) - at(0));
      longest = std::max(longest, (at((k + 1) % loop.size()) - at(k)).norm());
    }
    const double area = 0.5 * twice.norm();
    if (!(area > slack * longest)) continue;
    Vec3 normal = twice.normalized();
    for (std::size_t k = 1; k + 1 < loop.size(); ++k)
      first += normal.dot((at(k) - at(0)).cross(at(k + 1) - at(0))) / 6 * (at(0) + at(k) + at(k + 1));
    const Vec3 middle = first / area;
    for (std::size_t k = 0; k < loop.size(); ++k)
      if (const double off = std::abs(normal.dot(at(k) - middle)); off > slack)
        fail(s, fmt::format(
                    "a face of it is bent: a corner is {:.3g} off its plane, more than {:.3g} (Neper: without -reg)",
                    off, slack));
    if (normal.dot(middle - inside) < 0) normal = -normal;
    facets.push_back({normal, middle, area, &loop});
  }
  std::stable_sort(facets.begin(), facets.end(), [](const Facet& a, const Facet& b) { return a.area > b.area; });
  return facets;
}

/// All triangles of corners that have no corner beyond them: what bounds the hull of the corners.
std::vector<std::vector<int>> supporting(const Surface& s, double slack) {
  std::vector<std::vector<int>> triangles;
  const int n = static_cast<int>(s.corner.size());
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j)
      for (int k = j + 1; k < n; ++k) {
        const auto at = [&](int v) -> const Vec3& { return s.corner[static_cast<std::size_t>(v)]; };
        const Vec3 twice = (at(j) - at(i)).cross(at(k) - at(i)), normal = twice.normalized();
        const double longest = std::max({(at(j) - at(i)).norm(), (at(k) - at(j)).norm(), (at(i) - at(k)).norm()});
        if (!(0.5 * twice.norm() > slack * longest)) continue;
        bool below = true, above = true;
        for (const Vec3& x : s.corner) {
          const double off = normal.dot(x - at(i));
          below = below && off < slack, above = above && off > -slack;
        }
        if (below || above) triangles.push_back({i, j, k});
      }
  return triangles;
}

std::vector<MergedFace> merged(const Surface& s, const std::vector<Facet>& facets, double slack) {
  constexpr double same_side = 0.5;
  std::vector<MergedFace> faces;
  for (const Facet& facet : facets) {
    const auto in_plane = [&](const MergedFace& f) {
      return f.normal.dot(facet.normal) > same_side && std::all_of(facet.loop->begin(), facet.loop->end(), [&](int v) {
               return std::abs(f.normal.dot(s.corner[static_cast<std::size_t>(v)]) - f.offset) <= slack;
             });
    };
    auto found = std::find_if(faces.begin(), faces.end(), in_plane);
    if (found == faces.end()) {
      faces.push_back({facet.normal, Vec3::Zero(), Vec3::Zero(), facet.normal.dot(facet.middle), 0});
      found = faces.end() - 1;
    }
    found->sum += facet.area * facet.normal, found->weighted += facet.area * facet.middle;
    found->area += facet.area;
  }
  for (MergedFace& f : faces) f.settle();
  return faces;
}

}  // namespace

double slack_of(const std::vector<Vec3>& corners, double tolerance) {
  Vec3 low = corners.front(), high = low;
  for (const Vec3& x : corners) low = low.cwiseMin(x), high = high.cwiseMax(x);
  return std::max(tolerance * (high - low).norm(),
                  single_precision * std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff()));
}

Polyhedron body_of(const Surface& given, double tolerance) {
  const bool hull = given.face.empty();
  if (given.corner.size() < 4 || (!hull && given.face.size() < 4))
    fail(given, fmt::format("{} corners and {} faces bound no body", given.corner.size(), given.face.size()));
  if (hull && given.corner.size() > most_hull_vertices)
    fail(given, fmt::format("has {} corners, more than the {} that a hull has room for", given.corner.size(),
                            most_hull_vertices));
  Surface filled;
  if (hull) filled = given, filled.face = supporting(given, slack_of(given.corner, tolerance));
  const Surface& s = hull ? filled : given;
  Vec3 low = s.corner.front(), high = low, inside = Vec3::Zero();
  for (const Vec3& x : s.corner) {
    low = low.cwiseMin(x), high = high.cwiseMax(x);
    inside += x / static_cast<double>(s.corner.size());
  }
  const double size = (high - low).norm(), slack = slack_of(s.corner, tolerance);
  const auto facets = facets_of(s, inside, slack);
  const auto faces = merged(s, facets, slack);
  double volume = 0, surface = 0;
  for (const Facet& f : facets) volume += f.area * f.normal.dot(f.middle - inside) / 3, surface += f.area;
  if (facets.empty() || !(volume > slack * surface)) fail(s, "is flat, or has no volume");
  for (const MergedFace& f : faces)
    for (const Vec3& x : s.corner)
      if (const double beyond = f.normal.dot(x) - f.offset; beyond > 3 * slack)
        fail(s, fmt::format("is not convex: a corner lies {:.3g} beyond one of its faces. Cut it into convex bodies; "
                            "bodies that touch need a solid or an object of their own each",
                            beyond));
  if (faces.size() > most_hull_faces)
    fail(s,
         fmt::format("has {} faces, more than the {} that a hull has room for: make its mesh coarser; spheres are read "
                     "by kind = \"file\", from lines x y z r",
                     faces.size(), most_hull_faces));
  Polyhedron body = box_between(low - Vec3::Constant(size), high + Vec3::Constant(size));
  for (std::size_t k = 0; k < faces.size(); ++k)
    cut(body, faces[k].normal, faces[k].offset, static_cast<std::int64_t>(k), slack);
  const bool open = body.empty() || std::any_of(body.face.begin(), body.face.end(),
                                                [](const Polyhedron::Face& f) { return f.tag < 0; });
  if (open || (!hull && std::abs(moments_of(body).volume - volume) > 3 * slack * surface))
    fail(s, "is not closed: faces are missing, or lie twice in one place");
  if (body.vertex.size() > most_hull_vertices)
    fail(s, fmt::format("has {} corners, more than the {} that a hull has room for: make its mesh coarser",
                        body.vertex.size(), most_hull_vertices));
  return body;
}

std::vector<Surface> parts_of(const Surface& whole) {
  std::map<std::array<double, 3>, int> places;
  std::vector<int> at;  // of each corner its place
  for (const Vec3& x : whole.corner)
    at.push_back(places.try_emplace({x.x(), x.y(), x.z()}, static_cast<int>(places.size())).first->second);
  std::vector<int> root(places.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int k) {
    while (root[static_cast<std::size_t>(k)] != k) {
      int& up = root[static_cast<std::size_t>(k)];
      k = up = root[static_cast<std::size_t>(up)];
    }
    return k;
  };
  for (const auto& loop : whole.face)
    for (const int v : loop) {
      const int a = find(at[static_cast<std::size_t>(loop[0])]), b = find(at[static_cast<std::size_t>(v)]);
      root[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  std::vector<Surface> parts;
  std::map<int, std::size_t> part_of;
  std::vector<int> place(places.size(), -1);  // in its part
  for (const auto& loop : whole.face) {
    const int r = find(at[static_cast<std::size_t>(loop[0])]);
    const auto [found, fresh] = part_of.try_emplace(r, parts.size());
    if (fresh) parts.push_back({.group = whole.group, .name = whole.name});
    Surface& part = parts[found->second];
    std::vector<int> own;
    for (const int v : loop) {
      int& p = place[static_cast<std::size_t>(at[static_cast<std::size_t>(v)])];
      if (p < 0) {
        p = static_cast<int>(part.corner.size());
        part.corner.push_back(whole.corner[static_cast<std::size_t>(v)]);
      }
      own.push_back(p);
    }
    part.face.push_back(std::move(own));
  }
  if (parts.size() > 1)
    for (std::size_t k = 0; k < parts.size(); ++k) parts[k].name += fmt::format(", part {}", k + 1);
  return parts;
}

}  // namespace grus::dem
