// SPDX-License-Identifier: LGPL-3.0-or-later
// The potential of two hulls' overlap: closed forms, differences, a cut of the bodies, and one way of finding it
// against the other.
#include "dem/contact/hull_overlaps.hpp"
#include "dem/shape/separation.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// U / c by cutting one polyhedron with the planes of the other: shares no code with the overlap's clipping.
double energy_by_cuts(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift) {
  std::vector<Vec3> points(a.vertex, a.vertex + a.vertices);
  Polyhedron k = hull_of(points);
  std::vector<Plane> planes_b;
  for (int f = 0; f < b.faces; ++f) {
    const Vec3 n = turn * b.plane[f].normal;
    planes_b.push_back({n, b.plane[f].offset + n.dot(shift)});
    cut(k, n, planes_b.back().offset, 0, 1e-14);
    if (k.empty()) return 0;
  }
  const SolidMoments m = moments_of(k);
  int plane = 0;
  double least = INFINITY;
  for (const Plane& p : planes_b) least = std::min(least, p.offset - p.normal.dot(m.centre));
  return 0.5 * m.volume * (depth_below(a, m.centre, plane) + least);
}

const Mat3 identity = Mat3::Identity();  // a pose looks at what it is given

double energy_at(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, const Vec3& search) {
  return overlap_of(a, b, turn, shift, search).energy;
}

}  // namespace

TEST_CASE("a unit cube on a plane: force and energy on a face, an edge and a vertex") {
  const Shape cube(unit_cube());
  const auto pressed = [&](const Vec3& down) {  // by 0.01
    const Vec3 n = -down.normalized();
    const double lowest = -support(cube.view(), -n).dot(-n);
    return overlap_with_plane(cube.view(), {n, lowest + 0.01}, 1);
  };
  const Mat3 back = cube.place.axes.toRotationMatrix().transpose();
  const Overlap face = pressed(back * Vec3(0, 0, -1)), edge = pressed(back * Vec3(1, 0, -1)),
                vertex = pressed(back * Vec3(1, 1, -1));
  CHECK(face.force.norm() == Approx(1e-2).epsilon(1e-9));
  CHECK(face.energy == Approx(5e-5).epsilon(1e-9));
  CHECK(face.area.norm() == Approx(1).epsilon(1e-9));
  CHECK(face.polar == Approx(1 / 6.0 + 4 * 0.01 * 0.25).epsilon(0.03));  // and the strips of its sides
  CHECK(edge.force.norm() == Approx(1.207107e-4).epsilon(1e-6));
  CHECK(edge.energy == Approx(4.023689e-7).epsilon(1e-6));
  CHECK(vertex.force.norm() == Approx(1.183013e-6).epsilon(1e-6));
  CHECK(vertex.energy == Approx(2.957532e-9).epsilon(1e-6));
}

TEST_CASE("a cube on a plane rocks as on an elastic foundation: c I less what gravity's arm takes") {
  const Shape cube(unit_cube());
  const double c = 1e6, depth = 1e-3, angle = 1e-6;
  const auto torque = [&](double turn) {  // about its centre, 0.499 above the plane
    const Vec3 n = rotation_by(turn * Vec3::UnitX()).conjugate() * Vec3::UnitZ();
    const Overlap o = overlap_with_plane(cube.view(), {n, -(0.5 - depth)}, 1);
    return -c * o.moment.x();  // on the cube
  };
  CHECK(-(torque(angle) - torque(-angle)) / (2 * angle) == Approx(c / 12 - c * depth * 0.5).epsilon(1e-3));
}

TEST_CASE("force and moment of an overlap are the gradient of its energy; the energy is that of the cut body") {
  const Tessellation cells = some_cells(64);
  std::vector<Shape> shapes;
  for (const Polyhedron& body : cells.body) shapes.emplace_back(body);
  int touching = 0, kinks = 0;
  double worst_force = 0, worst_moment = 0, worst_energy = 0;
  for (std::uint64_t n = 0; n < 3000; ++n) {
    const HullView a = shapes[n % 64].view(), b = shapes[(7 * n + 3) % 64].view();
    const Mat3 turn = random_rotation(n, 1).toRotationMatrix();
    const Vec3 along = random_vector(n, 2).normalized();
    const double size = 0.25;  // cube root of 1 / 64
    const Vec3 shift = along * size * (0.75 + 0.3 * random_uniform(3, n, Purpose::position));
    const Overlap o = overlap_of(a, b, turn, shift, along);
    const double scale = size * size * size;
    if (o.volume < 1e-6 * scale) continue;
    ++touching;
    worst_energy = std::max(worst_energy, std::abs(o.energy - energy_by_cuts(a, b, turn, shift)) / o.energy);
    const double h = 1e-6 * size;
    Vec3 force, moment;
    for (int k = 0; k < 3; ++k) {
      const Vec3 d = h * Vec3::Unit(k);
      force[k] = -(energy_at(a, b, turn, shift + d, along) - energy_at(a, b, turn, shift - d, along)) / (2 * h);
      const Mat3 plus = rotation_by(1e-6 * Vec3::Unit(k)).toRotationMatrix(), minus = plus.transpose();
      moment[k] =
          -(energy_at(a, b, plus * turn, plus * shift, along) - energy_at(a, b, minus * turn, minus * shift, along)) /
          2e-6;
    }
    const double off_force = (force - o.force).norm() / o.force.norm(),
                 off_moment = (moment - o.moment).norm() / (size * o.force.norm());
    if (std::max(off_force, off_moment) > 1e-5)  // another plane is the least deep within the difference: a kink of U
      ++kinks;
    else
      worst_force = std::max(worst_force, off_force), worst_moment = std::max(worst_moment, off_moment);
  }
  CHECK(touching > 1500);
  CHECK(worst_energy < 1e-7);
  CHECK(worst_force < 2e-6);
  CHECK(worst_moment < 2e-6);
  CHECK(kinks <= 3);  // a step of 1e-6 meets one in some thousand poses
}

TEST_CASE("the overlap by edges is that by clipped faces") {
  const Tessellation cells = some_cells(64);
  std::vector<Shape> shapes;
  for (const Polyhedron& body : cells.body) shapes.emplace_back(body);
  shapes.emplace_back(box_between(Vec3::Constant(-0.1), Vec3::Constant(0.1)));
  const double size = 0.25;
  int met = 0, apart = 0, parted = 0, unsettled = 0;
  double worst = 0;
  const auto differ = [](const Vec3& x, const Vec3& y, double scale) { return (x - y).norm() / scale; };
  for (std::uint64_t n = 0; n < 20000; ++n) {
    const HullView a = shapes[n % 65].view(), b = shapes[(7 * n + 3) % 65].view();
    const Mat3 turn = random_rotation(n, 1).toRotationMatrix();
    const Vec3 along = random_vector(n, 2).normalized();
    const Vec3 shift = along * size * (0.5 + random_uniform(3, n, Purpose::position));
    const Vec3 search = n % 3 == 0 ? random_vector(n, 3).normalized() : along;
    const Overlap o = overlap_by_faces(a, b, turn, shift, search);
    HullWrench w;
    const Meets meets =
        hull_overlap()(columns_of(a), columns_of(b), pose_of(identity, turn, shift, search), nullptr, w);
    unsettled += meets == Meets::unsettled;
    if (meets == Meets::unsettled) continue;
    CHECK((meets == Meets::parted) == o.parted);
    parted += o.parted, apart += meets == Meets::apart, met += meets == Meets::overlaps;
    const double extent = size * size * size;
    if (o.volume < 1e-9 * extent) {
      CHECK((meets != Meets::overlaps || w.volume < 2e-9 * extent));
      continue;
    }
    REQUIRE(meets == Meets::overlaps);
    const double force = o.force.norm(), area = o.area.norm();
    for (const double off :
         {std::abs(w.volume / o.volume - 1), std::abs(w.energy / o.energy - 1), std::abs(w.polar / o.polar - 1),
          differ(Vec3(w.force), o.force, force), differ(Vec3(w.moment), o.moment, size * force),
          differ(Vec3(w.area), o.area, area), differ(Vec3(w.middle), o.middle, size)})
      worst = std::max(worst, off);
  }
  CAPTURE(met, apart, parted, unsettled, worst);
  CHECK(met > 8000);
  CHECK(apart > 200);
  CHECK(parted > 1000);
  CHECK(unsettled == 0);  // random poses meet no tie
  CHECK(worst < 1e-6);    // bodies that overlap by 1e-3 of their size lose nine digits of second moments
}

TEST_CASE("where edges meet edges and corners corners exactly, the overlap is that of the cut body, too") {
  HullStore store;
  HullPlace place;
  add_hull(store, unit_cube(), place);
  const std::vector<Vec3> corners{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  add_hull(store, hull_of(corners), place);
  int unsettled = 0;
  double worst = 0;
  for (const Index one : {0u, 1u})
    for (const Index two : {0u, 1u})
      for (int n = 0; n < 2 * 343; ++n) {
        const Mat3 turn = rotation_by(n % 2 * pi / 4 * Vec3::UnitZ()).toRotationMatrix();
        const Vec3 shift = 0.25 * Vec3(n / 2 % 7 - 3, n / 14 % 7 - 3, n / 98 % 7 - 3);
        if (shift == Vec3::Zero()) continue;
        const Vec3 search = shift.normalized();
        const Overlap found = overlap_of(store[one], store[two], turn, shift, search);
        const double energy = energy_by_cuts(store[one], store[two], turn, shift);
        worst = std::max(worst, std::abs(found.energy - energy));
        HullWrench w;
        unsettled += hull_overlap()(columns_of(store[one]), columns_of(store[two]),
                                    pose_of(identity, turn, shift, search), nullptr, w) == Meets::unsettled;
      }
  CHECK(unsettled > 100);  // these are left to overlap_by_faces
  CHECK(worst < 1e-9);
}

TEST_CASE("overlaps of any depth down to round-off, however thin, press by no more than they are deep") {
  Team team(1);
  const Tessellation cells = voronoi_packing(box_space(Vec3::Ones()), 64, 5, 3, team);
  std::vector<Vec3> corners;
  for (int k = 0; k < 32; ++k) corners.emplace_back(0.3 * std::sin(pi * k / 16), -0.3 * std::cos(pi * k / 16), 0);
  Polyhedron roller = prism_over(corners, -1, 1);
  Mat3 upright;
  upright << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  place(roller, upright, Vec3::Zero());
  HullStore store;
  const Index tool = add_unturned(store, roller);
  int touching = 0;
  for (const Polyhedron& body : cells.body) {
    HullPlace at;
    const HullView cell = store[add_hull(store, body, at)];
    const Mat3 back = at.axes.toRotationMatrix().transpose();
    for (double depth = 1e-16; depth < 1e-2; depth *= 3)
      for (const double x : {0.02, 0.3, 0.5, 0.8, 1.0}) {
        const Vec3 to = Vec3(x, 0.5, 1.3 - depth) - at.origin;
        const Overlap o = overlap_of(cell, store[tool], back, back * to, back * Vec3(to.x(), 0, to.z()).normalized());
        if (!(o.volume > 0) || !(o.area.norm() > 0)) continue;
        ++touching;
        CHECK(o.force.norm() < 1.5 * depth * o.area.norm() + 1e-11 * o.area.norm());
      }
  }
  CHECK(touching > 400);
}

TEST_CASE("faces that are flush but for round-off press by what they are deep, whatever plane is the nearest then") {
  std::vector<Vec3> corners;
  for (int k = 0; k < 6; ++k) corners.emplace_back(std::cos(pi / 3 * k + 0.2), std::sin(pi / 3 * k + 0.2), 0);
  const Shape prism(prism_over(corners, -1, 1));
  const HullView hull = prism.view();
  const Mat3 back = prism.place.axes.toRotationMatrix().transpose();
  int pressed = 0;
  for (std::uint64_t n = 0; n < 400; ++n)
    for (double depth = 1e-17; depth < 1e-8; depth *= 10) {
      const Vec3 tilt = 0.1 * depth * random_vector(n, 3), slip = random_uniform(1, n, Purpose::position) < 0.5
                                                                      ? Vec3::Zero()
                                                                      : Vec3(0.1 * random_vector(n, 4).x(), 0.05, 0);
      const Mat3 turn = back * rotation_by(tilt).toRotationMatrix() * back.transpose();
      const Vec3 shift = back * (Vec3(0, 0, 2 - depth) + slip), search = (back * (Vec3::UnitZ() + tilt)).normalized();
      for (const Overlap& o :
           {overlap_of(hull, hull, turn, shift, search), overlap_by_faces(hull, hull, turn, shift, search)}) {
        if (!(o.volume > 0)) continue;
        ++pressed;
        CHECK(o.energy > 0);
        CHECK(o.force.norm() < 2 * depth * o.area.norm());
        CHECK(o.moment.norm() < 2 * depth * o.area.norm() * shift.norm());
        CHECK(o.area.norm() > 0.5);
      }
    }
  CHECK(pressed > 1000);
}

TEST_CASE("what is looked at along any direction gives the same overlap, and both bodies agree on it") {
  const Tessellation cells = some_cells(27);
  const Shape one(cells.body[3]), two(cells.body[11]);
  const Mat3 turn = random_rotation(5, 5).toRotationMatrix();
  const Vec3 shift(0.2, 0.1, -0.15);
  const Overlap o = overlap_of(one.view(), two.view(), turn, shift, shift.normalized());
  REQUIRE(o.volume > 0);
  for (std::uint64_t n = 0; n < 50; ++n) {
    const Overlap again = overlap_of(one.view(), two.view(), turn, shift, random_vector(n, 9).normalized());
    CHECK(again.volume == Approx(o.volume).epsilon(1e-9));
    CHECK((again.force - o.force).norm() < 1e-9 * o.force.norm());
    CHECK((again.moment - o.moment).norm() < 1e-9 * o.moment.norm());
  }
  const Overlap other =
      overlap_of(two.view(), one.view(), turn.transpose(), -(turn.transpose() * shift), Vec3::UnitX());
  CHECK((turn * other.force + o.force).norm() < 1e-9 * o.force.norm());
  CHECK((turn * other.area + o.area).norm() < 1e-9 * o.area.norm());
  CHECK(other.energy == Approx(o.energy).epsilon(1e-9));
}

TEST_CASE("cubes that lie flush side by side feel the face alone, whichever way round-off goes") {
  const Shape cube(unit_cube());
  for (std::uint64_t n = 0; n < 200; ++n) {
    Vec3 shift = 1e-16 * random_vector(n, 4);
    shift.z() = 1 - 1e-4;
    for (const bool by_faces : {false, true}) {
      const auto find = [&](auto&&... of) { return by_faces ? overlap_by_faces(of...) : overlap_of(of...); };
      const Overlap o = find(cube.view(), cube.view(), Mat3::Identity(), shift, Vec3::UnitZ());
      CHECK(o.volume == Approx(1e-4).epsilon(3e-8));  // in one plane: to 1e-12 of the size
      CHECK((o.force - 1e-4 * Vec3::UnitZ()).norm() < 1e-12);
      CHECK((o.moment - o.middle.cross(o.force)).norm() < 1e-12);
    }
  }
}

TEST_CASE("hulls are apart where a face's normal parts them") {
  const Shape cube(unit_cube());
  Vec3 direction;
  CHECK(face_separation(cube.view(), cube.view(), Mat3::Identity(), Vec3(0.3, 0, 1.2), direction) == Approx(0.2));
  CHECK(direction.z() == Approx(1));
  CHECK(face_separation(cube.view(), cube.view(), Mat3::Identity(), Vec3(0.3, 0, 0.9), direction) == Approx(-0.1));
}
