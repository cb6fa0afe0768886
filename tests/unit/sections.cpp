// SPDX-License-Identifier: LGPL-3.0-or-later
// Where planes cut hulls, and what parts of bonded faces carry.
#include "dem/bond/faces.hpp"
#include "dem/packing/prisms.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "dem/rve/breakage.hpp"
#include "dem/shape/section.hpp"
#include "tests/bonded.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

TEST_CASE("sections and parts of hulls: those of the polyhedron that a cut makes") {
  const Tessellation cells = some_cells(64);
  for (std::size_t i = 0; i < cells.body.size(); ++i) {
    const Shape shape(cells.body[i]);
    const double size = std::cbrt(shape.store.row[0].volume);
    for (std::uint64_t k = 0; k < 20; ++k) {
      const Vec3 n = random_vector(i, k).normalized();
      const double offset = 0.4 * size * (random_uniform(5, i, Purpose::turn, k) - 0.5);
      Polyhedron above = body_of(shape.view());
      cut(above, -n, -offset, 99, 0);
      const SolidMoments whole = moments_of(above), part = part_beyond(shape.view(), n, offset);
      CHECK(std::abs(part.volume / whole.volume - 1) < 1e-12);
      CHECK((part.centre - whole.centre).norm() < 1e-12 * size);
      CHECK((part.second - whole.second).norm() < 1e-12 * whole.second.norm());
      const auto cap = std::find_if(above.face.begin(), above.face.end(), [](const auto& f) { return f.tag == 99; });
      REQUIRE(cap != above.face.end());
      const FaceMoments face = moments_of(above, *cap);
      const FlatMoments flat = moments_of(section_of(shape.view(), n, offset));
      const std::array<Vec3, 2> e = across(n);
      CHECK(std::abs(flat.area / face.area - 1) < 1e-12);
      const Vec3 centre = offset * n + flat.first.x() / flat.area * e[0] + flat.first.y() / flat.area * e[1];
      CHECK((centre - face.centre).norm() < 1e-11 * size);
      Mat3 second = face.second + face.area * (face.centre - offset * n) * (face.centre - offset * n).transpose();
      for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b)
          CHECK(std::abs(e[static_cast<std::size_t>(a)].dot(second * e[static_cast<std::size_t>(b)]) -
                         flat.second(a, b)) < 1e-12 * size * size * size * size);
    }
  }
}

TEST_CASE("planes beside a hull, in a face and through a corner of a cube") {
  const Shape cube(unit_cube());
  CHECK(section_of(cube.view(), Vec3::UnitX(), 0.6).corners == 0);
  CHECK(part_beyond(cube.view(), Vec3::UnitX(), 0.6).volume == 0);
  CHECK(part_beyond(cube.view(), Vec3::UnitX(), -0.6).volume == Approx(1));
  CHECK(moments_of(section_of(cube.view(), Vec3::UnitX(), -0.5)).area == Approx(1));  // what is in the plane is below
  const Vec3 diagonal = Vec3::Ones().normalized();
  CHECK(moments_of(section_of(cube.view(), diagonal, 0)).area == Approx(0.75 * std::sqrt(3.0)));
  CHECK(part_beyond(cube.view(), diagonal, 0.5 / std::sqrt(3.0)).volume == Approx(1.0 / 6));
  CHECK(part_beyond(cube.view(), diagonal, 0.5 * std::sqrt(3.0)).volume < 1e-15);
}

TEST_CASE("a plane through a corner cuts off what planes just before and behind it do") {
  const Tessellation cells = some_cells(8);
  for (const Polyhedron& body : cells.body) {
    const Shape shape(body);
    const double size = std::cbrt(shape.store.row[0].volume), near = 1e-9 * size;
    for (int v = 0; v < shape.view().vertices; ++v)
      for (int k = 0; k < 3; ++k) {
        const Vec3 corner = shape.view().vertex[v];
        const auto beyond = [&](double off) { return part_beyond(shape.view(), Vec3::Unit(k), corner[k] + off); };
        const SolidMoments before = beyond(-near), at = beyond(0), behind = beyond(near);
        CHECK(before.volume >= at.volume - 1e-14 * size * size * size);
        CHECK(at.volume >= behind.volume - 1e-14 * size * size * size);
        if (at.volume > 0.1 * size * size * size) CHECK((before.centre - at.centre).norm() < 1e3 * near);
      }
  }
}

TEST_CASE("the polygon of a bond has its area and moments; parts of it add up to the whole") {
  const Model model = rock(elastic());
  Team team(1);
  State s;
  add_voronoi_grains(model, voronoi_packing(box_space(Vec3(3, 3, 3)), 60, 3, 2, team), 0, s);
  std::size_t large = 0;
  for (const FaceBond& b : s.bonds.face.row) {
    const FlatPolygon p = polygon_of(s.grains, b, false);
    const FlatMoments m = moments_of(p);
    CHECK(std::abs(m.area - b.area) < 1e-12);
    CHECK(m.first.norm() < 1e-12);
    CHECK(std::abs(m.second(0, 0) - b.i2) + std::abs(m.second(1, 1) - b.i1) + std::abs(m.second(0, 1)) < 1e-12);
    if (b.area < 0.05) continue;
    ++large;
    const Eigen::Vector2d slope = Eigen::Vector2d(b.i1 - b.i2, b.area).normalized();
    const FlatMoments below = moments_of(clipped(p, slope, 0.1)), above = moments_of(clipped(p, -slope, -0.1));
    const FaceWrench whole{Vec3(1, 2, 3), Vec3(0.4, -0.2, 0.3)}, f = carried({b.area, b.i1, b.i2}, whole, below),
                                                                 g = carried({b.area, b.i1, b.i2}, whole, above);
    CHECK((f.force + g.force - whole.force).norm() < 1e-9);
    CHECK((f.couple + g.couple - whole.couple).norm() < 1e-9);
  }
  CHECK(large > 100);
}

TEST_CASE("what half a square carries of a force, of bending and of twist") {
  FlatPolygon half;
  for (const Eigen::Vector2d& y :
       {Eigen::Vector2d(0, -1), Eigen::Vector2d(1, -1), Eigen::Vector2d(1, 1), Eigen::Vector2d(0, 1)})
    half.add(y);
  const FaceSize square{4, 4.0 / 3, 4.0 / 3};
  const FlatMoments part = moments_of(half);
  const FaceWrench pulled = carried(square, {Vec3(0, 0, 4), Vec3::Zero()}, part);
  CHECK((pulled.force - Vec3(0, 0, 2)).norm() < 1e-14);
  CHECK((pulled.couple - Vec3(0, -1, 0)).norm() < 1e-14);  // at (1/2, 0)
  // A couple about y of 4/3 is a tension of -x: the half has -1 of it, its couple is half of the whole.
  const FaceWrench bent = carried(square, {Vec3::Zero(), Vec3(0, 4.0 / 3, 0)}, part);
  CHECK((bent.force - Vec3(0, 0, -1)).norm() < 1e-14);
  CHECK((bent.couple - Vec3(0, 2.0 / 3, 0)).norm() < 1e-14);
  const FaceWrench twisted = carried(square, {Vec3::Zero(), Vec3(0, 0, 8.0 / 3)}, part);
  CHECK((twisted.force - Vec3(0, 1, 0)).norm() < 1e-14);
  CHECK((twisted.couple - Vec3(0, 0, 4.0 / 3)).norm() < 1e-14);
}

TEST_CASE("a bond in two parts resists any small motion as the whole did, whichever grain gives way to a piece") {
  const Model model = rock(elastic(0.4));
  Team team(1);
  State s;
  add_voronoi_grains(model, voronoi_packing(box_space(Vec3(2, 2, 2)), 12, 3, 2, team), 0, s);
  for (const FaceBond& b : s.bonds.face.row) {
    if (b.area < 0.05) continue;
    const FlatPolygon p = polygon_of(s.grains, b, false);
    const Eigen::Vector2d slope(0.6, 0.8);
    std::array<FaceBond, 2> part{part_of(b, moments_of(clipped(p, slope, 0.02)), Quat::Identity()),
                                 part_of(b, moments_of(clipped(p, -slope, -0.02)), Quat::Identity())};
    // Another frame of either grain changes nothing.
    const Quat turn = random_rotation(4, 9);
    const Vec3 shift(0.1, -0.3, 0.2);
    Grains g = s.grains;
    rehang(part[0], 0, b.ends.a, turn, shift), rehang(part[1], 1, b.ends.b, turn, shift);
    const Vec3 move(1e-6, -2e-6, 3e-6), angle(2e-6, 1e-6, -1e-6);
    const Quat little(1, 0.5 * angle.x(), 0.5 * angle.y(), 0.5 * angle.z());
    const Quat qa = g.orientation[b.ends.a], qb = little.normalized() * g.orientation[b.ends.b];
    const Vec3 xa = g.motion[b.ends.a].position, xb = g.motion[b.ends.b].position + move;
    const auto on_b = [&](FaceBond row, int other) {
      const Quat pa = other == 0 ? qa * turn : qa, pb = other == 1 ? qb * turn : qb;
      const Vec3 ya = other == 0 ? Vec3(xa + qa * shift) : xa, yb = other == 1 ? Vec3(xb + qb * shift) : xb;
      const Pull pull = grus::dem::pull(row, {pa, pb, ya, yb}, {&s.grains});
      return std::pair<Vec3, Vec3>{pull.force, pull.couple + (yb + pull.arm_b - xb).cross(pull.force)};
    };
    const auto whole = on_b(b, 2), first = on_b(part[0], 0), second = on_b(part[1], 1);
    CHECK((first.first + second.first - whole.first).norm() < 1e-5 * whole.first.norm());
    CHECK((first.second + second.second - whole.second).norm() < 1e-5 * whole.second.norm());
    CHECK(std::abs(part[0].area + part[1].area - b.area) < 1e-12);
  }
}

TEST_CASE(
    "a prism cut a hair beside two opposite corners: pieces with two parallel faces know which one a bond is of") {
  Model model = rock(elastic(0.4), 0.5);
  FractureModel fracture;
  fracture.criteria.emplace_back(Cleavage{.toughness = 1e30, .flaw = 1e-2});
  fracture.splitter = Cut{false, 0};
  model.materials[0].fracture = fracture;
  Team team(1);
  State s;
  add_voronoi_grains(model, hexagonal_prisms(Vec3(4, 4, 1), 0.5, 1, 0), 0, s);
  prepare(model, s, team);
  const Vec3 n(-0.5, std::sqrt(0.75), 0);  // across a corner, along two faces
  std::size_t slivers = 0;
  for (const double beside : {1e-5, -1e-5}) {
    std::vector<Break> breaks;
    for (std::size_t i = 0; i < 10; ++i)
      breaks.push_back({i + (beside < 0 ? 10 : 0), {Mat3::Zero(), n, Vec3::Zero(), beside}});
    apply_breaks(model, s, breaks, team);
  }
  REQUIRE(s.grains.size() > 30);
  for (const FaceBond& b : s.bonds.face.row) {
    CHECK(std::abs(moments_of(polygon_of(s.grains, b, false)).area - b.area) < 1e-12);
    slivers += b.area < 1e-4;
  }
  CHECK(slivers > 5);
}
