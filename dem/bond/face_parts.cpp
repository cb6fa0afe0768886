// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/bond/face_parts.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

/// Adds the triangle of the origin and an edge.
void add_triangle(const Eigen::Vector2d& p, const Eigen::Vector2d& q, FlatMoments& m) {
  const double part = 0.5 * (p.x() * q.y() - p.y() * q.x());
  const Eigen::Vector2d sum = p + q;
  m.area += part, m.first += part / 3 * sum;
  m.second += part / 12 * (sum * sum.transpose() + p * p.transpose() + q * q.transpose());
}

}  // namespace

FlatMoments pressed_part(const FaceOpening& o, std::span<const Eigen::Vector2d> corner) {
  FlatMoments m;
  Eigen::Vector2d from = corner.back(), leaves = from, enters = from;
  double before = o.at(from);
  bool crosses = false;
  for (const Eigen::Vector2d& to : corner) {
    const double now = o.at(to);
    if (before <= 0 && now <= 0) {
      add_triangle(from, to, m);
    } else if ((before < 0) != (now < 0)) {
      const Eigen::Vector2d at = from + before / (before - now) * (to - from);
      crosses = true;
      if (before < 0)
        add_triangle(from, at, m), leaves = at;
      else
        add_triangle(at, to, m), enters = at;
    }
    from = to, before = now;
  }
  if (crosses) add_triangle(leaves, enters, m);
  return m;
}

FaceParts parts_of(const FaceOpening& o, const FlatMoments& whole, std::span<const Eigen::Vector2d> corner) {
  const OpeningSums all = sums_over(o, whole);
  double least = INFINITY, most = -INFINITY;
  for (const Eigen::Vector2d& y : corner) {
    const double at = o.at(y);
    least = std::min(least, at), most = std::max(most, at);
  }
  if (!(least < 0)) return {{}, {}, all};
  if (!(most > 0)) return {whole, all, {}};
  FaceParts parts;
  parts.pressed = pressed_part(o, corner);
  parts.of_pressed = sums_over(o, parts.pressed), parts.of_open = all - parts.of_pressed;
  return parts;
}

}  // namespace grus::dem
