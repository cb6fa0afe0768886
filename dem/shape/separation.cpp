// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/separation.hpp"

#include <array>

namespace grus::dem {
namespace {

/// Up to four differences of a point of B and one of A; after `nearest` those alone that the nearest point needs.
struct Simplex {
  std::array<Vec3, 4> point;
  std::size_t count = 0;

  void keep(std::initializer_list<Vec3> some) {
    count = 0;
    for (const Vec3& p : some) point[count++] = p;
  }
};

Vec3 nearest_on_segment(const Vec3& a, const Vec3& b, Simplex& s) {
  const Vec3 ab = b - a;
  const double to = -a.dot(ab), length2 = ab.squaredNorm();
  if (to <= 0) return s.keep({a}), a;
  if (to >= length2) return s.keep({b}), b;
  s.keep({a, b});
  return a + to / length2 * ab;
}

/// By the regions of a triangle's corners, edges and face.
Vec3 nearest_on_triangle(const Vec3& a, const Vec3& b, const Vec3& c, Simplex& s) {
  const Vec3 ab = b - a, ac = c - a;
  const double d1 = -ab.dot(a), d2 = -ac.dot(a);
  if (d1 <= 0 && d2 <= 0) return s.keep({a}), a;
  const double d3 = -ab.dot(b), d4 = -ac.dot(b);
  if (d3 >= 0 && d4 <= d3) return s.keep({b}), b;
  const double d5 = -ab.dot(c), d6 = -ac.dot(c);
  if (d6 >= 0 && d5 <= d6) return s.keep({c}), c;
  if (d1 * d4 - d3 * d2 <= 0 && d1 >= 0 && d3 <= 0) return nearest_on_segment(a, b, s);
  if (d5 * d2 - d1 * d6 <= 0 && d2 >= 0 && d6 <= 0) return nearest_on_segment(a, c, s);
  if (d3 * d6 - d5 * d4 <= 0 && d4 >= d3 && d5 >= d6) return nearest_on_segment(b, c, s);
  s.keep({a, b, c});
  const Vec3 n = ab.cross(ac);
  return n.dot(a) / n.squaredNorm() * n;
}

/// The point of the simplex nearest to the origin; none where the origin is inside.
bool nearest(Simplex& s, Vec3& v) {
  const std::array<Vec3, 4> p = s.point;
  if (s.count == 1) return v = p[0], true;
  if (s.count == 2) return v = nearest_on_segment(p[0], p[1], s), true;
  if (s.count == 3) return v = nearest_on_triangle(p[0], p[1], p[2], s), true;
  double least = INFINITY;
  static constexpr std::array<std::array<std::size_t, 4>, 4> faces{
      {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}}};
  for (const auto& [i, j, k, other] : faces) {
    const Vec3 n = (p[j] - p[i]).cross(p[k] - p[i]);
    if (-n.dot(p[i]) * n.dot(p[other] - p[i]) > 0) continue;  // the origin is on the inner side
    Simplex part;
    const Vec3 x = nearest_on_triangle(p[i], p[j], p[k], part);
    if (const double far = x.squaredNorm(); far < least) least = far, v = x, s = part;
  }
  return least < INFINITY;
}

}  // namespace

double separation(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, Vec3& direction) {
  constexpr int most_rounds = 64;
  const Mat3 back = turn.transpose();
  Simplex simplex;
  Vec3 v = direction == Vec3::Zero() ? shift : direction;
  double found = -INFINITY, last = INFINITY;
  for (int round = 0; round < most_rounds; ++round) {
    const double size2 = v.squaredNorm();
    if (!(size2 > 0)) break;
    const Vec3 n = v / std::sqrt(size2), w = shift + turn * support(b, -(back * n)) - support(a, n);
    if (const double along = n.dot(w); along > found) {
      found = along;
      if (along > 0) direction = n;
    }
    // No corner is nearer than the point itself, or round-off stirs alone.
    if (round > 0 && (v.dot(w) >= (1 - 1e-14) * size2 || size2 >= last)) break;
    if (round > 0) last = size2;
    simplex.point[simplex.count++] = w;
    if (!nearest(simplex, v)) break;
  }
  return found;
}

double separation_along(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, const Vec3& n) {
  return n.dot(shift + turn * support(b, -(turn.transpose() * n)) - support(a, n));
}

double face_separation(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, Vec3& direction) {
  double most = -INFINITY;
  const auto consider = [&](const Vec3& n) {
    if (const double s = separation_along(a, b, turn, shift, n); s > most) most = s, direction = n;
  };
  if (shift != Vec3::Zero()) consider(shift.normalized());
  for (int f = 0; f < a.faces; ++f) consider(a.plane[f].normal);
  for (int f = 0; f < b.faces; ++f) consider(-(turn * b.plane[f].normal));
  return most;
}

}  // namespace grus::dem
