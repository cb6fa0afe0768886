// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/polyhedron.hpp"

#include <algorithm>
#include <optional>

#include "dem/base/error.hpp"

namespace grus::dem {
namespace {

constexpr std::size_t most_points = 64;

/// Points of a convex polygon in order, counter-clockwise about `normal`.
void sort_around(const std::vector<Vec3>& vertex, const Vec3& normal, std::vector<int>& loop) {
  Vec3 middle = Vec3::Zero();
  for (const int v : loop) middle += vertex[static_cast<std::size_t>(v)];
  middle /= static_cast<double>(loop.size());
  const std::array<Vec3, 2> e = across(normal);
  const auto angle = [&](int v) {
    const Vec3 x = vertex[static_cast<std::size_t>(v)] - middle;
    return std::atan2(e[1].dot(x), e[0].dot(x));
  };
  std::sort(loop.begin(), loop.end(), [&](int a, int b) { return angle(a) < angle(b); });
}

/// Forgets vertices of no face.
void compact(Polyhedron& body) {
  std::vector<int> place(body.vertex.size(), -1);
  int kept = 0;
  for (auto& face : body.face)
    for (int& v : face.loop) {
      int& at = place[static_cast<std::size_t>(v)];
      if (at < 0) at = kept++;
      v = at;
    }
  std::vector<Vec3> vertex(static_cast<std::size_t>(kept));
  for (std::size_t v = 0; v < place.size(); ++v)
    if (place[v] >= 0) vertex[static_cast<std::size_t>(place[v])] = body.vertex[v];
  body.vertex = std::move(vertex);
}

/// Where edges cross a plane: neighbouring faces share the point.
struct Crossings {
  struct Edge {
    int from, to, point;
  };
  std::vector<Edge> edge;

  int find(int a, int b) const {
    for (const Edge& e : edge)
      if ((e.from == a && e.to == b) || (e.from == b && e.to == a)) return e.point;
    return -1;
  }
};

Polyhedron faceless(std::span<const Vec3> points) {
  if (points.size() < 4 || points.size() > most_points)
    throw InputError("a hull has 4 to 64 vertices, not " + std::to_string(points.size()));
  return {{points.begin(), points.end()}, {}};
}

double size_of(std::span<const Vec3> points) {
  double size = 0;
  for (const Vec3& p : points) size = std::max(size, (p - points[0]).norm());
  return size;
}

/// The face of a hull through three of its points, if all points are on one side of it.
std::optional<Polyhedron::Face> face_through(std::span<const Vec3> points, std::array<std::size_t, 3> at,
                                             double tolerance) {
  const Vec3 &a = points[at[0]], &b = points[at[1]], &c = points[at[2]];
  Vec3 n = (b - a).cross(c - a);
  if (!(n.norm() > tolerance * ((b - a).norm() + (c - a).norm()))) return {};
  n.normalize();
  bool below = true, above = true;
  std::vector<int> on;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const double d = n.dot(points[p] - a);
    below = below && d < tolerance, above = above && d > -tolerance;
    if (std::abs(d) < tolerance) on.push_back(static_cast<int>(p));
  }
  if (below == above) return {};
  if (above) n = -n;
  return Polyhedron::Face{n, n.dot(a), 0, on};
}

/// Corners of the convex polygon about points in a plane, counter-clockwise about `normal`: those inside it or on its
/// edges are left out (Andrew's chains).
std::vector<int> corners_of(const std::vector<Vec3>& vertex, const Vec3& normal, const std::vector<int>& points,
                            double tolerance) {
  const std::array<Vec3, 2> e = across(normal);
  const auto flat = [&](int v) {
    const Vec3& x = vertex[static_cast<std::size_t>(v)];
    return Eigen::Vector2d(e[0].dot(x), e[1].dot(x));
  };
  std::vector<int> order = points;
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const Eigen::Vector2d p = flat(a), q = flat(b);
    return std::abs(p.x() - q.x()) > tolerance ? p.x() < q.x() : p.y() < q.y();
  });
  const auto turns_left = [&](int a, int b, int c) {
    const Eigen::Vector2d along = flat(c) - flat(a), way = flat(b) - flat(a);
    return way.x() * along.y() - way.y() * along.x() > tolerance * along.norm();
  };
  std::vector<int> loop;
  for (const bool upper : {false, true}) {
    const std::size_t first = loop.size();
    for (const int v : order) {
      while (loop.size() >= first + 2 && !turns_left(loop[loop.size() - 2], loop.back(), v)) loop.pop_back();
      loop.push_back(v);
    }
    loop.pop_back();
    if (!upper) std::reverse(order.begin(), order.end());
  }
  return loop;
}

}  // namespace

std::array<Vec3, 2> across(const Vec3& n) {
  Eigen::Index least;
  n.cwiseAbs().minCoeff(&least);
  const Vec3 e1 = n.cross(Vec3::Unit(least)).normalized();
  return {e1, n.cross(e1)};
}

Polyhedron prism_over(std::span<const Vec3> corners, double low, double high) {
  Polyhedron body;
  const int n = static_cast<int>(corners.size());
  for (const double z : {low, high})
    for (const Vec3& c : corners) body.vertex.emplace_back(c.x(), c.y(), z);
  std::vector<int> bottom, top;
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    const Vec3 &a = body.vertex[static_cast<std::size_t>(k)], &b = body.vertex[static_cast<std::size_t>(next)];
    const Vec3 normal = (b - a).cross(Vec3::UnitZ()).normalized();
    body.face.push_back({normal, normal.dot(a), -1 - k, {k, next, n + next, n + k}});
    bottom.push_back(n - 1 - k), top.push_back(n + k);
  }
  body.face.push_back({-Vec3::UnitZ(), -low, -1 - n, bottom});
  body.face.push_back({Vec3::UnitZ(), high, -2 - n, top});
  return body;
}

Polyhedron box_between(const Vec3& low, const Vec3& high) {
  const std::array<Vec3, 4> corners{Vec3(low.x(), low.y(), 0), Vec3(high.x(), low.y(), 0), Vec3(high.x(), high.y(), 0),
                                    Vec3(low.x(), high.y(), 0)};
  Polyhedron p = prism_over(corners, low.z(), high.z());
  const std::array<std::size_t, 6> order{3, 1, 0, 2, 4, 5};
  Polyhedron box{p.vertex, {}};
  for (std::size_t k = 0; k < order.size(); ++k) {
    box.face.push_back(p.face[order[k]]);
    box.face.back().tag = -1 - static_cast<std::int64_t>(k);
  }
  return box;
}

Polyhedron hull_of(std::span<const Vec3> points) {
  Polyhedron body = faceless(points);
  const double tolerance = 1e-10 * size_of(points);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j)
      for (std::size_t k = j + 1; k < points.size(); ++k) {
        auto face = face_through(points, {i, j, k}, tolerance);
        if (!face) continue;
        const auto same = [&](const Polyhedron::Face& f) {
          return f.normal.dot(face->normal) > 0.5 &&
                 std::includes(f.loop.begin(), f.loop.end(), face->loop.begin(), face->loop.end());
        };
        if (std::none_of(body.face.begin(), body.face.end(), same)) body.face.push_back(*face);
      }
  if (body.face.size() < 4) throw InputError("the points of a hull lie in a plane, or nearly so");
  for (auto& face : body.face) {
    face.loop = corners_of(body.vertex, face.normal, face.loop, tolerance);
    sort_around(body.vertex, face.normal, face.loop);
  }
  compact(body);
  return body;
}

bool cut(Polyhedron& body, const Vec3& normal, double offset, std::int64_t tag, double tolerance) {
  std::vector<double> above(body.vertex.size());
  bool some_out = false, some_in = false;
  for (std::size_t v = 0; v < above.size(); ++v) {
    above[v] = normal.dot(body.vertex[v]) - offset;
    if (std::abs(above[v]) < tolerance) above[v] = 0;
    some_out = some_out || above[v] > 0, some_in = some_in || above[v] < 0;
  }
  if (!some_out) return false;
  if (!some_in) {
    body = {};
    return true;
  }
  Crossings crossings;
  Polyhedron::Face cap{normal, offset, tag, {}};
  for (std::size_t v = 0; v < above.size(); ++v)
    if (above[v] == 0) cap.loop.push_back(static_cast<int>(v));
  std::vector<int> kept;
  for (auto& face : body.face) {
    kept.clear();
    for (std::size_t k = 0; k < face.loop.size(); ++k) {
      const int from = face.loop[k], to = face.loop[(k + 1) % face.loop.size()];
      const double a = above[static_cast<std::size_t>(from)], b = above[static_cast<std::size_t>(to)];
      if (a <= 0) kept.push_back(from);
      if (!((a < 0 && b > 0) || (a > 0 && b < 0))) continue;
      int point = crossings.find(from, to);
      if (point < 0) {
        point = static_cast<int>(body.vertex.size());
        const Vec3 x = body.vertex[static_cast<std::size_t>(from)], y = body.vertex[static_cast<std::size_t>(to)];
        body.vertex.push_back(a < 0 ? Vec3(x + a / (a - b) * (y - x)) : Vec3(y + b / (b - a) * (x - y)));
        crossings.edge.push_back({from, to, point});
        cap.loop.push_back(point);
      }
      kept.push_back(point);
    }
    face.loop = kept;
  }
  std::erase_if(body.face, [](const Polyhedron::Face& f) { return f.loop.size() < 3; });
  if (cap.loop.size() >= 3) {
    sort_around(body.vertex, normal, cap.loop);
    body.face.push_back(std::move(cap));
  }
  compact(body);
  return true;
}

SolidMoments moments_of(const Polyhedron& body) {
  // Tetrahedra from a vertex: from a far origin their volumes would cancel.
  const Vec3 origin = body.vertex[0];
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (const auto& face : body.face) {
    const Vec3 a = body.vertex[static_cast<std::size_t>(face.loop[0])] - origin;
    for (std::size_t k = 1; k + 1 < face.loop.size(); ++k) {
      const Vec3 b = body.vertex[static_cast<std::size_t>(face.loop[k])] - origin;
      const Vec3 c = body.vertex[static_cast<std::size_t>(face.loop[k + 1])] - origin;
      const double det = a.dot(b.cross(c));
      const Vec3 sum = a + b + c;
      volume += det / 6, first += det / 24 * sum;
      second += det / 120 * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
    }
  }
  const Vec3 centre = first / volume;
  return {volume, origin + centre, second - volume * centre * centre.transpose()};
}

double least_width(const Polyhedron& body) {
  double least = INFINITY;
  for (const Polyhedron::Face& face : body.face) {
    double low = INFINITY, high = -INFINITY;
    for (const Vec3& x : body.vertex)
      low = std::min(low, face.normal.dot(x)), high = std::max(high, face.normal.dot(x));
    least = std::min(least, high - low);
  }
  return least;
}

FaceMoments moments_of(const Polyhedron& body, const Polyhedron::Face& face) {
  const Vec3 origin = body.vertex[static_cast<std::size_t>(face.loop[0])];
  double area = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (std::size_t k = 1; k + 1 < face.loop.size(); ++k) {
    const Vec3 b = body.vertex[static_cast<std::size_t>(face.loop[k])] - origin;
    const Vec3 c = body.vertex[static_cast<std::size_t>(face.loop[k + 1])] - origin;
    const double part = 0.5 * face.normal.dot(b.cross(c));
    const Vec3 sum = b + c;
    area += part, first += part / 3 * sum;
    second += part / 12 * (sum * sum.transpose() + b * b.transpose() + c * c.transpose());
  }
  const Vec3 centre = area > 0 ? Vec3(first / area) : Vec3(Vec3::Zero());
  return {area, origin + centre, second - area * centre * centre.transpose()};
}

void place(Polyhedron& body, const Mat3& r, const Vec3& shift) {
  for (Vec3& x : body.vertex) x = r * x + shift;
  for (auto& face : body.face) face.normal = r * face.normal, face.offset += face.normal.dot(shift);
}

void stretch(Polyhedron& body, const Vec3& factors) {
  for (Vec3& x : body.vertex) x = x.cwiseProduct(factors);
  for (auto& face : body.face) {
    const Vec3 n = face.normal.cwiseQuotient(factors);
    face.offset /= n.norm(), face.normal = n.normalized();
  }
}

}  // namespace grus::dem
