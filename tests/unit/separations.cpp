// SPDX-License-Identifier: LGPL-3.0-or-later
// How far hulls are apart: closed forms, and every feature of one against every feature of the other.
#include "dem/shape/separation.hpp"

#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

double from_point_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = (b - a).cross(c - a);
  const auto left = [&](const Vec3& x, const Vec3& y) { return n.dot((y - x).cross(p - x)) >= 0; };
  return left(a, b) && left(b, c) && left(c, a) ? std::abs(n.dot(p - a)) / n.norm() : INFINITY;
}

double between_segments(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  const auto to_point = [](const Vec3& x, const Vec3& a, const Vec3& b) {
    const double t = std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (a + t * (b - a) - x).norm();
  };
  double least = std::min({to_point(p, r, s), to_point(q, r, s), to_point(r, p, q), to_point(s, p, q)});
  const Vec3 u = q - p, v = s - r, n = u.cross(v), w = r - p;
  if (n.squaredNorm() > 1e-16 * u.squaredNorm() * v.squaredNorm()) {
    const double t = w.cross(v).dot(n) / n.squaredNorm(), k = w.cross(u).dot(n) / n.squaredNorm();
    if (t > 0 && t < 1 && k > 0 && k < 1) least = std::min(least, std::abs(w.dot(n)) / n.norm());
  }
  return least;
}

/// Of hulls that are apart.
double by_features(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift) {
  std::vector<Vec3> of_b;
  for (int v = 0; v < b.vertices; ++v) of_b.push_back(turn * b.vertex[v] + shift);
  const std::vector<Vec3> of_a(a.vertex, a.vertex + a.vertices);
  double least = INFINITY;
  for (int e = 0; e < a.edges; ++e)
    for (int f = 0; f < b.edges; ++f)
      least = std::min(least, between_segments(of_a[a.edge[4 * e]], of_a[a.edge[4 * e + 1]], of_b[b.edge[4 * f]],
                                               of_b[b.edge[4 * f + 1]]));
  const auto on_faces = [&](const std::vector<Vec3>& points, const HullView& h, const std::vector<Vec3>& corner) {
    for (int f = 0; f < h.faces; ++f)
      for (int k = h.begin[f] + 1; k + 1 < h.begin[f + 1]; ++k)
        for (const Vec3& p : points)
          least = std::min(
              least, from_point_to_triangle(p, corner[h.loop[h.begin[f]]], corner[h.loop[k]], corner[h.loop[k + 1]]));
  };
  on_faces(of_a, b, of_b), on_faces(of_b, a, of_a);
  return least;
}

}  // namespace

TEST_CASE("cubes edge over edge at 60 degrees, 0.1 apart: edges tell their distance, faces do not") {
  const Shape cube(unit_cube());
  const Mat3 upright = rotation_by(pi / 4 * Vec3::UnitX()).toRotationMatrix(),
             crossed = rotation_by(pi / 3 * Vec3::UnitZ()).toRotationMatrix() * upright;
  const Mat3 back = upright.transpose(), turn = back * crossed;
  const Vec3 shift = back * Vec3(0.2, 0.3, std::sqrt(2.0) + 0.1);
  Vec3 direction = Vec3::Zero(), by_faces;
  CHECK(separation(cube.view(), cube.view(), turn, shift, direction) == Approx(0.1).epsilon(1e-11));
  CHECK((upright * direction - Vec3::UnitZ()).norm() < 1e-9);
  CHECK(face_separation(cube.view(), cube.view(), turn, shift, by_faces) < 0.01);
}

TEST_CASE("the distance of hulls is that of their nearest features, from any beginning; its direction parts them") {
  const Tessellation cells = some_cells(64);
  std::vector<Shape> shapes;
  for (const Polyhedron& body : cells.body) shapes.emplace_back(body);
  int apart = 0;
  double worst = 0, unparted = 0;
  for (std::uint64_t n = 0; n < 3000; ++n) {
    const HullView a = shapes[n % 64].view(), b = shapes[(7 * n + 3) % 64].view();
    const Mat3 turn = random_rotation(n, 1).toRotationMatrix();
    const Vec3 shift = (0.2 + 0.3 * random_uniform(3, n, Purpose::position)) * random_vector(n, 2).normalized();
    Vec3 direction = n % 3 == 0 ? Vec3(Vec3::Zero()) : Vec3(random_vector(n, 3).normalized());
    const Vec3 before = direction;
    const double found = separation(a, b, turn, shift, direction);
    if (!(found > 0)) {  // they meet: what parts them least deep is below 0
      Vec3 some;
      CHECK(face_separation(a, b, turn, shift, some) <= 1e-12);
      CHECK(direction == before);
      continue;
    }
    ++apart;
    worst = std::max(worst, std::abs(found - by_features(a, b, turn, shift)));
    unparted = std::max(unparted, std::abs(separation_along(a, b, turn, shift, direction) - found));
    CHECK(std::abs(direction.norm() - 1) < 1e-12);
  }
  CHECK(apart > 1000);
  CHECK(worst < 1e-12);
  CHECK(unparted < 1e-15);
}

TEST_CASE("hulls that touch at a point, an edge or a face are as good as not apart") {
  const Shape cube(unit_cube());
  for (const Vec3& shift : {Vec3(1, 1, 1), Vec3(1, 1, 0.3), Vec3(1, 0.2, 0.3), Vec3(1, 0, 0)}) {
    Vec3 direction = Vec3::Zero();
    CHECK(separation(cube.view(), cube.view(), Mat3::Identity(), shift, direction) < 1e-12);
    direction = Vec3::Zero();
    const Vec3 further = 1.25 * shift;
    const Vec3 gap = (further.cwiseAbs() - Vec3::Ones()).cwiseMax(0);
    CHECK(separation(cube.view(), cube.view(), Mat3::Identity(), further, direction) == Approx(gap.norm()));
  }
}
