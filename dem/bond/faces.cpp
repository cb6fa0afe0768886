// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/bond/faces.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

/// Axes in a plane along which second moments are principal, the first by an angle from the plane's own; turns about it
/// meet i1.
struct Principal {
  double angle, i1, i2;
};

Principal principal_of(double uu, double vv, double uv) {
  const double angle = 0.5 * std::atan2(2 * uv, uu - vv), c = std::cos(angle), s = std::sin(angle);
  const double along = c * c * uu + 2 * c * s * uv + s * s * vv;
  return {angle, uu + vv - along, along};  // a turn about an axis opens by the distance from it
}

/// Keeps what is inside a hull of the plane through `at` (its frame), once that is moved along its normal onto the
/// hull's own face. `outward`: the normal, out of this hull; a face on its other side may be as parallel.
void clip_by(const HullView& hull, Vec3 at, const Vec3& outward, const Vec3& e1, const Vec3& e2, FlatPolygon& p) {
  int face = 0;
  double most = -INFINITY;
  for (int f = 0; f < hull.faces; ++f)
    if (const double along = hull.plane[f].normal.dot(outward); along > most) most = along, face = f;
  const Plane& own = hull.plane[face];
  at += (own.offset - own.normal.dot(at)) / own.normal.dot(outward) * outward;
  for (int f = 0; f < hull.faces; ++f) {
    const Plane& plane = hull.plane[f];
    if (f == face) continue;
    p = clipped(p, {plane.normal.dot(e1), plane.normal.dot(e2)}, plane.offset - plane.normal.dot(at));
  }
}

}  // namespace

FaceBond bond_at(const Grains& g, Index a, const FaceMoments& face, const Vec3& normal) {
  FaceBond s;
  const Quat& q = g.orientation[a];
  const std::array<Vec3, 2> e = across(normal);
  const Principal p =
      principal_of(e[0].dot(face.second * e[0]), e[1].dot(face.second * e[1]), e[0].dot(face.second * e[1]));
  s.ends.a = a;
  s.at_a = q.conjugate() * (face.centre - g.motion[a].position);
  s.normal = q.conjugate() * normal;
  s.e1 = q.conjugate() * (std::cos(p.angle) * e[0] + std::sin(p.angle) * e[1]);
  s.area = face.area, s.i1 = p.i1, s.i2 = p.i2;
  return s;
}

FlatPolygon polygon_of(const Grains& g, const FaceBond& s, bool walled) {
  const Vec3 e2 = s.normal.cross(s.e1);
  const double wide = 2 * g.motion[s.ends.a].radius;
  FlatPolygon p;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) p.add({x * wide, y * wide});
  clip_by((*g.hulls)[g.hull[s.ends.a]], s.at_a, s.normal, s.e1, e2, p);
  if (walled) return p;
  const Quat to_b = s.rest;  // at rest, from the frame of a to that of b
  clip_by((*g.hulls)[g.hull[s.ends.b]], s.at_b, -(to_b * s.normal), to_b * s.e1, to_b * e2, p);
  return p;
}

FlatPolygon outline_of(const Grains& g, const FaceBond& s) {
  FlatPolygon p = polygon_of(g, s, false);
  const FlatMoments m = moments_of(p);
  const Eigen::Vector2d middle = m.first / m.area;
  for (int k = 0; k < p.corners; ++k) p.corner[static_cast<std::size_t>(k)] -= middle;
  return p;
}

FaceWrench carried(const FaceSize& s, const FaceWrench& whole, const FlatMoments& part) {
  // Traction: force / area + normal (slope . y) + twist normal x y.
  const Eigen::Vector2d slope(-whole.couple.y() / s.i2, whole.couple.x() / s.i1);
  const double twist = whole.couple.z() / (s.i1 + s.i2);
  const Vec3 mean = whole.force / s.area, y(part.first.x(), part.first.y(), 0);
  const Eigen::Vector2d bent = part.second * slope;
  const Vec3 force = part.area * mean + Vec3(-twist * y.y(), twist * y.x(), slope.dot(part.first));
  return {force, y.cross(mean) + Vec3(bent.y(), -bent.x(), twist * part.second.trace())};
}

FaceBond part_of(const FaceBond& s, const FlatMoments& part, const Quat& turn) {
  FaceBond out = s;
  const Eigen::Vector2d middle = part.first / part.area;
  const Eigen::Matrix2d second = part.second - part.area * middle * middle.transpose();
  const Principal p = principal_of(second(0, 0), second(1, 1), second(0, 1));
  const Vec3 e2 = s.normal.cross(s.e1), way = middle.x() * s.e1 + middle.y() * e2;
  out.at_a += way, out.at_b += s.rest * way;
  out.e1 = std::cos(p.angle) * s.e1 + std::sin(p.angle) * e2;
  const Vec3 further = turn * way - way, slip = s.slip_1 * s.e1 + s.slip_2 * e2 + further;
  out.slip_1 = slip.dot(out.e1), out.slip_2 = slip.dot(s.normal.cross(out.e1));
  out.area = part.area, out.i1 = p.i1, out.i2 = p.i2;
  const double share = part.area / s.area;
  out.spent *= share, out.rubbed *= share, out.held *= share, out.force *= share, out.shear *= share;
  return out;
}

void rehang(FaceBond& s, int end, Index piece, const Quat& turn, const Vec3& shift) {
  const Quat back = turn.conjugate();
  if (end == 1) {
    s.ends.b = piece;
    s.at_b = back * (s.at_b - shift);
    s.rest = back * s.rest;
    return;
  }
  s.ends.a = piece;
  s.at_a = back * (s.at_a - shift), s.normal = back * s.normal, s.e1 = back * s.e1;
  s.rest = s.rest * turn;
}

}  // namespace grus::dem
