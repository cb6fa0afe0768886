// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/overlap.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace grus::dem {
namespace {

constexpr int most_corners = most_hull_vertices + most_hull_faces;

/// A body's points and planes in the frame of A, and those faces that can bound the overlap.
struct Body {
  Body(const Vec3* v, const Plane* p, const std::uint16_t* first, const std::uint8_t* corners, int count_of_faces)
      : vertex(v), plane(p), begin(first), loop(corners), faces(count_of_faces) {}

  const Vec3* vertex;
  const Plane* plane;
  const std::uint16_t* begin;
  const std::uint8_t* loop;
  int faces;
  std::array<std::uint8_t, most_hull_faces> near{};  // those faces
  int count = 0;
  std::array<std::uint64_t, most_hull_vertices> beyond;  // by vertex: above which of the other's near planes it is
};

/// Planes of `other` clip a face; what is left.
struct Polygon {
  std::array<Vec3, most_corners> one, two;
  Vec3 *now = one.data(), *next = two.data();
  int corners = 0;
};

bool clip(Polygon& p, const Plane& plane, double slack) {
  std::array<double, most_corners> above;
  bool some_out = false, some_in = false;
  for (int k = 0; k < p.corners; ++k) {
    const double d = above[static_cast<std::size_t>(k)] = plane.normal.dot(p.now[k]) - plane.offset - slack;
    (d > 0 ? some_out : some_in) = true;
  }
  if (!some_out) return true;
  if (!some_in) return false;
  int kept = 0;
  for (int k = 0; k < p.corners; ++k) {
    const int to = k + 1 < p.corners ? k + 1 : 0;
    const double a = above[static_cast<std::size_t>(k)], b = above[static_cast<std::size_t>(to)];
    if (a <= 0) p.next[kept++] = p.now[k];
    if ((a <= 0) != (b <= 0)) p.next[kept++] = p.now[k] + a / (a - b) * (p.now[to] - p.now[k]);
  }
  std::swap(p.now, p.next);
  p.corners = kept;
  return kept >= 3;
}

void find_beyond(Body& body, const Body& other, double slack) {
  std::uint64_t found = 0;
  for (int n = 0; n < body.count; ++n) {
    const int f = body.near[static_cast<std::size_t>(n)];
    for (int k = body.begin[f]; k < body.begin[f + 1]; ++k) {
      const std::uint8_t v = body.loop[k];
      if ((found >> v & 1) != 0) continue;
      found |= std::uint64_t{1} << v;
      std::uint64_t above = 0;
      for (int m = 0; m < other.count; ++m) {
        const Plane& plane = other.plane[other.near[static_cast<std::size_t>(m)]];
        above |= std::uint64_t{plane.normal.dot(body.vertex[v]) - plane.offset - slack > 0} << m;
      }
      body.beyond[v] = above;
    }
  }
}

/// The part of face f of `body` that lies in `other`.
bool face_within(const Body& body, int f, const Body& other, double slack, Polygon& p) {
  p.corners = 0;
  std::uint64_t some = 0, all = ~std::uint64_t{0};
  for (int k = body.begin[f]; k < body.begin[f + 1]; ++k) {
    const std::uint8_t v = body.loop[k];
    p.now[p.corners++] = body.vertex[v];
    some |= body.beyond[v], all &= body.beyond[v];
  }
  if (all != 0) return false;
  for (; some != 0; some &= some - 1)
    if (!clip(p, other.plane[other.near[static_cast<std::size_t>(std::countr_zero(some))]], slack)) return false;
  return true;
}

/// Area, first and second moments about `origin`.
struct Moments {
  double area;
  Vec3 first;
  Mat3 second;
};

Moments moments_of(const Polygon& p, const Vec3& normal, const Vec3& origin) {
  Moments m{0, Vec3::Zero(), Mat3::Zero()};
  const Vec3 a = p.now[0] - origin;
  Vec3 b = p.now[1] - origin;
  for (int k = 2; k < p.corners; ++k) {
    const Vec3 c = p.now[k] - origin;
    const double part = 0.5 * normal.dot((b - a).cross(c - a));
    const Vec3 sum = a + b + c;
    m.area += part, m.first += part / 3 * sum;
    m.second += part / 12 * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
    b = c;
  }
  return m;
}

struct Part {
  int face;
  Moments moments;
};

/// The clipped faces of both, about a point of the overlap. Most of the room is never used, nor cleared.
struct Boundary {
  std::array<Part, most_hull_faces> of_a, of_b;
  int count_a = 0, count_b = 0;
  Vec3 origin = Vec3::Zero();
};

Boundary boundary_of(Body& a, Body& b, double slack) {
  Boundary k;
  Polygon p;
  find_beyond(b, a, -slack), find_beyond(a, b, slack);
  const auto gather = [&](const Body& body, const Body& other, double inside, std::array<Part, most_hull_faces>& parts,
                          int& count) {
    for (int n = 0; n < body.count; ++n) {
      const int f = body.near[static_cast<std::size_t>(n)];
      if (!face_within(body, f, other, inside, p)) continue;
      if (k.count_a + k.count_b == 0) k.origin = p.now[0];
      parts[static_cast<std::size_t>(count++)] = {f, moments_of(p, body.plane[f].normal, k.origin)};
    }
  };
  gather(b, a, -slack, k.of_b, k.count_b);
  gather(a, b, slack, k.of_a, k.count_a);
  return k;
}

/// The plane of `body` below which x is least deep.
Plane shallowest(const Body& body, const Vec3& x) {
  int best = 0;
  double least = INFINITY;
  for (int f = 0; f < body.faces; ++f)
    if (const double d = body.plane[f].offset - body.plane[f].normal.dot(x); d < least) least = d, best = f;
  return body.plane[best];
}

Overlap wrench_of(Body& a, Body& b, double slack) {
  const Boundary k = boundary_of(a, b, slack);
  Overlap out;
  double volume = 0;
  Vec3 first = Vec3::Zero();
  const auto add = [&](const Body& body, const Part& part) {
    const Plane& plane = body.plane[part.face];
    const double height = plane.offset - plane.normal.dot(k.origin);
    volume += height / 3 * part.moments.area, first += height / 4 * part.moments.first;
  };
  for (int n = 0; n < k.count_b; ++n) add(b, k.of_b[static_cast<std::size_t>(n)]);
  for (int n = 0; n < k.count_a; ++n) add(a, k.of_a[static_cast<std::size_t>(n)]);
  for (int n = 0; n < k.count_a; ++n) {
    const Part& part = k.of_a[static_cast<std::size_t>(n)];
    out.area += part.moments.area * a.plane[part.face].normal;
  }
  if (!(volume > 0 && volume > thin * slack * out.area.norm())) return {};
  const Vec3 centre = first / volume;  // from k.origin, as all that follows
  const Plane i = shallowest(a, k.origin + centre), j = shallowest(b, k.origin + centre);
  const Vec3 slope = -(i.normal + j.normal);
  const double level = i.offset + j.offset + slope.dot(k.origin), depth = level + slope.dot(centre);
  Vec3 force = volume * j.normal, moment = centre.cross(volume * j.normal);
  for (int n = 0; n < k.count_b; ++n) {
    const Part& part = k.of_b[static_cast<std::size_t>(n)];
    const Moments& m = part.moments;
    const Vec3& normal = b.plane[part.face].normal;
    force += (level * m.area + slope.dot(m.first)) * normal;
    moment += (level * m.first + m.second * slope).cross(normal);
  }
  // A closed surface has no area vector: one hull is in the other.
  const double area2 = std::max(out.area.squaredNorm(), 1e-300);
  Vec3 middle = Vec3::Zero();
  for (int n = 0; n < k.count_a; ++n) {
    const Part& part = k.of_a[static_cast<std::size_t>(n)];
    middle += a.plane[part.face].normal.dot(out.area) / area2 * part.moments.first;
  }
  for (int n = 0; n < k.count_a; ++n) {
    const Moments& m = k.of_a[static_cast<std::size_t>(n)].moments;
    out.polar += m.second.trace() - 2 * middle.dot(m.first) + m.area * middle.squaredNorm();
  }
  out.volume = volume;
  out.energy = 0.5 * volume * depth;
  out.force = -0.5 * force;
  out.moment = -0.5 * moment + k.origin.cross(out.force);
  out.middle = k.origin + middle;
  return out;
}

/// Faces of a body with a vertex on the near side of a level: `sign` 1: projections above it, -1: below.
void find_near(Body& body, const double* along, double level, double sign) {
  for (int f = 0; f < body.faces; ++f)
    for (int k = body.begin[f]; k < body.begin[f + 1]; ++k)
      if (sign * along[body.loop[k]] >= sign * level) {
        body.near[static_cast<std::size_t>(body.count++)] = static_cast<std::uint8_t>(f);
        break;
      }
}

}  // namespace

Overlap overlap_by_faces(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, const Vec3& n) {
  std::array<double, most_hull_vertices> along_a, along_b;
  double highest = -INFINITY, lowest = INFINITY;
  for (int v = 0; v < a.vertices; ++v) {
    const double x = along_a[static_cast<std::size_t>(v)] = n.dot(a.vertex[v]);
    highest = std::max(highest, x);
  }
  const Vec3 m = turn.transpose() * n;
  const double far = n.dot(shift);
  for (int v = 0; v < b.vertices; ++v) {
    const double x = along_b[static_cast<std::size_t>(v)] = m.dot(b.vertex[v]) + far;
    lowest = std::min(lowest, x);
  }
  if (highest <= lowest) return {.parted = true, .gap = lowest - highest};
  std::array<Vec3, most_hull_vertices> vertex;
  std::array<Plane, most_hull_faces> plane;
  for (int v = 0; v < b.vertices; ++v) vertex[static_cast<std::size_t>(v)] = turn * b.vertex[v] + shift;
  for (int f = 0; f < b.faces; ++f) {
    const Vec3 normal = turn * b.plane[f].normal;
    plane[static_cast<std::size_t>(f)] = {normal, b.plane[f].offset + normal.dot(shift)};
  }
  // What is beyond the slab between the two levels bounds nothing: a line from it to the overlap leaves by a face
  // within.
  Body of_a(a.vertex, a.plane, a.begin, a.loop, a.faces), of_b(vertex.data(), plane.data(), b.begin, b.loop, b.faces);
  find_near(of_a, along_a.data(), lowest, 1);
  find_near(of_b, along_b.data(), highest, -1);
  return wrench_of(of_a, of_b, flush_share * (std::abs(highest) + shift.norm()));
}

Overlap overlap_with_plane(const HullView& a, const Plane& wall, double radius) {
  std::array<double, most_hull_vertices> along;
  double highest = -INFINITY;
  for (int v = 0; v < a.vertices; ++v) {
    const double x = along[static_cast<std::size_t>(v)] = -wall.normal.dot(a.vertex[v]);
    highest = std::max(highest, x);
  }
  if (highest <= -wall.offset) return {.parted = true};
  Eigen::Index least;
  wall.normal.cwiseAbs().minCoeff(&least);
  const Vec3 e1 = 2 * radius * wall.normal.cross(Vec3::Unit(least)).normalized(), e2 = wall.normal.cross(e1);
  const Vec3 middle = wall.offset * wall.normal;
  const std::array<Vec3, 4> corner{middle + e1, middle + e2, middle - e1, middle - e2};
  static constexpr std::array<std::uint16_t, 2> begin{0, 4};
  static constexpr std::array<std::uint8_t, 4> loop{0, 1, 2, 3};
  Body of_a(a.vertex, a.plane, a.begin, a.loop, a.faces), of_b(corner.data(), &wall, begin.data(), loop.data(), 1);
  find_near(of_a, along.data(), -wall.offset, 1);
  of_b.count = 1;
  return wrench_of(of_a, of_b, flush_share * radius);
}

}  // namespace grus::dem
