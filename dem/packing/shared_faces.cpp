// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/shared_faces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "dem/base/error.hpp"
#include "dem/packing/surfaces.hpp"

namespace grus::dem {
namespace {

struct Extents {
  Vec3 low, high;
  double slack;
};

/// A body, or an image of it.
struct Copy {
  std::size_t body;
  std::array<std::int16_t, 3> image;
  Vec3 shift, low, high;
};

Extents extents_of(const Polyhedron& body, double tolerance) {
  Extents b{body.vertex.front(), body.vertex.front(), slack_of(body.vertex, tolerance)};
  for (const Vec3& x : body.vertex) b.low = b.low.cwiseMin(x), b.high = b.high.cwiseMax(x);
  return b;
}

/// All bodies, and those of their images that come near one, by their lower ends along x.
std::vector<Copy> copies_of(const std::vector<Extents>& bounds, const Vec3& periodic) {
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (const Extents& b : bounds) low = low.cwiseMin(b.low), high = high.cwiseMax(b.high);
  std::vector<Copy> copies;
  Eigen::Array3i image, most = Eigen::Array3i::Zero();
  for (int k = 0; k < 3; ++k)  // bodies may stick out of their box: those of a tessellation are whole
    if (periodic[k] > 0) most[k] = static_cast<int>(std::ceil((high[k] - low[k]) / periodic[k]));
  for (std::size_t i = 0; i < bounds.size(); ++i)
    for (image[0] = -most[0]; image[0] <= most[0]; ++image[0])
      for (image[1] = -most[1]; image[1] <= most[1]; ++image[1])
        for (image[2] = -most[2]; image[2] <= most[2]; ++image[2]) {
          const Vec3 shift = image.cast<double>().matrix().cwiseProduct(periodic),
                     margin = Vec3::Constant(bounds[i].slack);
          const Vec3 from = bounds[i].low + shift - margin, to = bounds[i].high + shift + margin;
          if ((from.array() > high.array()).any() || (to.array() < low.array()).any()) continue;
          const auto part = [&](int k) { return static_cast<std::int16_t>(image[k]); };
          copies.push_back({i, {part(0), part(1), part(2)}, shift, from, to});
        }
  std::stable_sort(copies.begin(), copies.end(), [](const Copy& a, const Copy& b) { return a.low.x() < b.low.x(); });
  return copies;
}

/// The part of face f of a that lies within face g of b, which is moved by `shift`; no vertices: they share nothing.
Polyhedron common(const Polyhedron& a, std::size_t f, const Polyhedron& b, std::size_t g, const Vec3& shift,
                  double slack) {
  constexpr double opposite = -0.999;
  const Polyhedron::Face &one = a.face[f], &other = b.face[g];
  if (one.normal.dot(other.normal) > opposite) return {};
  const double offset = other.offset + other.normal.dot(shift);
  for (const int v : one.loop)
    if (std::abs(other.normal.dot(a.vertex[static_cast<std::size_t>(v)]) - offset) > slack) return {};
  for (const int v : other.loop)
    if (std::abs(one.normal.dot(b.vertex[static_cast<std::size_t>(v)] + shift) - one.offset) > slack) return {};
  std::vector<Vec3> polygon;
  for (const int v : one.loop) polygon.push_back(a.vertex[static_cast<std::size_t>(v)]);
  for (std::size_t k = 0; k < other.loop.size() && !polygon.empty(); ++k) {
    const auto corner = [&](std::size_t m) -> Vec3 {
      return b.vertex[static_cast<std::size_t>(other.loop[m % other.loop.size()])] + shift;
    };
    const Vec3 from = corner(k), out = (corner(k + 1) - from).cross(other.normal);
    std::vector<Vec3> kept;
    for (std::size_t m = 0; m < polygon.size(); ++m) {
      const Vec3 &x = polygon[m], &y = polygon[(m + 1) % polygon.size()];
      const double dx = out.dot(x - from), dy = out.dot(y - from);
      if (dx <= 0) kept.push_back(x);
      if ((dx < 0 && dy > 0) || (dx > 0 && dy < 0)) kept.emplace_back(x + dx / (dx - dy) * (y - x));
    }
    polygon = std::move(kept);
  }
  if (polygon.size() < 3) return {};
  Polyhedron flat;
  flat.vertex = std::move(polygon);
  flat.face.push_back({one.normal, one.offset, 0, std::vector<int>(flat.vertex.size())});
  std::iota(flat.face[0].loop.begin(), flat.face[0].loop.end(), 0);
  return flat;
}

/// The volume that two bodies have in common, but for what is less than `slack` deep (m^3).
double common_volume(const Polyhedron& a, const Polyhedron& b, const Vec3& shift, double slack) {
  Polyhedron both = a;
  for (const auto& face : b.face) {
    cut(both, face.normal, face.offset + face.normal.dot(shift) - slack, face.tag, 0.01 * slack);
    if (both.empty()) return 0;
  }
  return moments_of(both).volume;
}

}  // namespace

SharedFaces shared_faces(const std::vector<Polyhedron>& bodies, const Vec3& periodic, double tolerance) {
  SharedFaces found;
  std::vector<Extents> bounds;
  std::vector<double> volume;
  for (const Polyhedron& body : bodies) {
    bounds.push_back(extents_of(body, tolerance));
    volume.push_back(moments_of(body).volume);
    found.shared.emplace_back(body.face.size(), std::uint8_t{0});
  }
  const auto meet = [&](std::size_t a, const Copy& other) {
    const std::size_t b = other.body;
    const double slack = bounds[a].slack + bounds[b].slack;
    bool touch = false;
    for (std::size_t f = 0; f < bodies[a].face.size(); ++f)
      for (std::size_t g = 0; g < bodies[b].face.size(); ++g) {
        const Polyhedron flat = common(bodies[a], f, bodies[b], g, other.shift, slack);
        if (flat.empty()) continue;
        const FaceMoments face = moments_of(flat, flat.face[0]);
        if (!(face.area > slack * slack)) continue;
        found.face.push_back({a, b, other.image, face, bodies[a].face[f].normal});
        found.shared[a][f] = found.shared[b][g] = touch = true;
      }
    if (touch) return true;
    const double share = common_volume(bodies[a], bodies[b], other.shift, slack) / std::min(volume[a], volume[b]);
    if (share > 0) ++found.overlap.pairs;
    if (share > found.overlap.share) found.overlap.share = share, found.overlap.a = a, found.overlap.b = b;
    return share > 0;
  };
  const std::vector<Copy> copies = copies_of(bounds, periodic);
  const auto whole = [](const Copy& c) { return c.image == std::array<std::int16_t, 3>{}; };
  for (std::size_t k = 0; k < copies.size(); ++k)
    for (std::size_t m = k + 1; m < copies.size() && copies[m].low.x() <= copies[k].high.x(); ++m) {
      const Copy &p = copies[k], &q = copies[m];
      if (!whole(p) && !whole(q)) continue;
      if ((p.low.array() > q.high.array()).any() || (q.low.array() > p.high.array()).any()) continue;
      const Copy &own = whole(p) ? p : q, &other = whole(p) ? q : p;
      if (own.body == other.body) {
        if (meet(own.body, other))
          throw InputError(fmt::format("body {} meets its own image: the periodic box is too small for it", own.body));
        continue;
      }
      // Each pair of images once: from the body of the lower number, whose image is then the box itself.
      if (whole(p) && whole(q))
        meet(std::min(p.body, q.body), p.body < q.body ? q : p);
      else if (own.body < other.body)
        meet(own.body, other);
    }
  std::sort(found.face.begin(), found.face.end(), [](const SharedFace& x, const SharedFace& y) {
    return std::tie(x.a, x.b, x.image, x.face.area) < std::tie(y.a, y.b, y.image, y.face.area);
  });
  return found;
}

}  // namespace grus::dem
