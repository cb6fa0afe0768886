// SPDX-License-Identifier: LGPL-3.0-or-later
// What an overlap was made of a step before is a guess: right, wrong or none, the bits are the same, and so are those
// of all widths of the kernels.
#include <cstring>

#include "dem/contact/hull_overlaps.hpp"
#include "dem/kernel/contact_pass.hpp"
#include "dem/shape/separation.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// B as it touches A along a direction but for `depth`: moved up to it by its distance again and again.
Vec3 touching(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& along, double depth) {
  Vec3 shift = 3 * along, direction = along;
  for (int round = 0; round < 100; ++round) {
    const double gap = separation(a, b, turn, shift, direction);
    if (!(gap > 1e-9)) break;
    shift -= gap / std::max(0.1, direction.dot(along)) * along;
  }
  return shift - depth * direction;
}

bool same(const HullWrench& x, const HullWrench& y) { return std::memcmp(&x, &y, sizeof x) == 0; }

struct Meeting {
  HullColumns a, b;
  Mat3 turn;
  Vec3 shift, search;
  Meets find(HullGuess* guess, HullWrench& out, HullOverlap kernel = hull_overlap()) const {
    const Mat3 identity = Mat3::Identity();
    std::memset(&out, 0, sizeof out);
    return kernel(a, b, pose_of(identity, turn, shift, search), guess, out);
  }
};

}  // namespace

TEST_CASE("a guess decides no bit: right, wrong, of another pose or none; and the overlap is that of clipped faces") {
  const Tessellation cells = some_cells(64);
  std::vector<Shape> shapes;
  for (const Polyhedron& body : cells.body) shapes.emplace_back(body);
  const double size = 0.25;
  int met = 0, kept = 0, held = 0, small = 0;
  double worst = 0;
  for (std::uint64_t n = 0; n < 20000; ++n) {
    const HullView a = shapes[n % 64].view(), b = shapes[(7 * n + 3) % 64].view();
    Meeting m{columns_of(a), columns_of(b), random_rotation(n, 1).toRotationMatrix(), {}, {}};
    const Vec3 along = random_vector(n, 2).normalized();
    const double depth = 0.5 * size * std::pow(10, -3 + 2 * random_uniform(3, n, Purpose::position));
    m.search = along, m.shift = touching(a, b, m.turn, along, depth);
    HullGuess guess;
    HullWrench none, first, right, wrong, moved, other;
    const Meets meets = m.find(nullptr, none);
    REQUIRE(meets == m.find(&guess, first));
    CHECK(same(none, first));
    if (meets != Meets::overlaps) continue;
    ++met, kept += guess.octets > 0;
    small += guess.octets == 2 && guess.octets_a == 1 && guess.borders <= 6;
    const HullGuess was = guess;
    CHECK(m.find(&guess, right) == meets);
    CHECK(same(none, right));
    held += std::memcmp(&was, &guess, 4) == 0;
    // Looked along anything else, the same bits; a step on the guess is as good or useless.
    m.search = (along + 0.5 * random_vector(n, 3)).normalized();
    CHECK(m.find(nullptr, other) == meets);
    CHECK(same(none, other));
    Meeting next = m;
    next.shift += 1e-3 * size * random_vector(n, 4), next.search = along;
    next.turn = rotation_by(1e-3 * random_vector(n, 5)).toRotationMatrix() * m.turn;
    const Meets then = next.find(&guess, wrong);
    CHECK(then == next.find(nullptr, moved));
    CHECK(same(wrong, moved));
    const Overlap o = overlap_by_faces(a, b, m.turn, m.shift, along);
    REQUIRE(o.volume > 0);
    const double force = o.force.norm();
    for (const double off :
         {std::abs(none.volume / o.volume - 1), std::abs(none.energy / o.energy - 1),
          (Vec3(none.force) - o.force).norm() / force, (Vec3(none.moment) - o.moment).norm() / (size * force)})
      worst = std::max(worst, off);
  }
  CAPTURE(met, kept, held, small, worst);
  CHECK(met > 19000);
  CHECK(kept > 0.999 * met);
  CHECK(held > 0.999 * met);  // as good as always what was found is looked at and found true
  CHECK(small > 5000);        // edge across edge, corner below face
  CHECK(worst < 1e-7);
}

TEST_CASE("kernels of one, four and eight lanes find the same bits with and without a guess") {
  const Tessellation cells = some_cells(27);
  std::vector<Shape> shapes;
  for (const Polyhedron& body : cells.body) shapes.emplace_back(body);
  int met = 0;
  for (std::uint64_t n = 0; n < 2000; ++n) {
    const HullView a = shapes[n % 27].view(), b = shapes[(5 * n + 2) % 27].view();
    Meeting m{columns_of(a), columns_of(b), random_rotation(n, 1).toRotationMatrix(), {}, {}};
    m.search = random_vector(n, 2).normalized();
    m.shift = touching(a, b, m.turn, m.search, 0.02 * random_uniform(3, n, Purpose::position));
    HullGuess one, more;
    HullWrench scalar, wide;
    const Meets meets = m.find(&one, scalar, lanes1::hull_overlap);
    const auto as_one = [&](HullOverlap kernel) {
      CHECK(m.find(&more, wide, kernel) == meets);
      CHECK(same(scalar, wide));
      CHECK(m.find(&more, wide, kernel) == meets);  // with the guess of the call before
      CHECK(same(scalar, wide));
    };
    as_one(lanes1::hull_overlap), as_one(hull_overlap());
#if defined(__x86_64__)
    if (lanes() >= 4) as_one(lanes4::hull_overlap);
#endif
    met += meets == Meets::overlaps;
  }
  CHECK(met > 1500);
}

TEST_CASE("unit cubes, edge across edge at 90 and 45 degrees: volume, energy, force and couple in closed form") {
  // Two wedges of right angles meet in a tetrahedron of height d, whose edges are 2 d long and cross at `angle`.
  const Shape cube(unit_cube());
  const Mat3 upright = rotation_by(pi / 4 * Vec3::UnitX()).toRotationMatrix();  // an edge along x on top
  for (const auto& [angle, volume, energy, force, couple] :
       {std::tuple{pi / 2, 6.666667e-7, 2.357023e-9, 9.428090e-7, 0.0},
        std::tuple{pi / 4, 9.428090e-7, 3.333333e-9, 1.333333e-6, 3.333333e-9}}) {
    const Mat3 axes = rotation_by(angle * Vec3::UnitZ()).toRotationMatrix() * upright;
    const Vec3 shift(0, 0, std::sqrt(2.0) - 0.01);
    HullGuess guess;
    for (int with = 0; with < 2; ++with) {
      const Overlap o = overlap_of(cube.view(), cube.view(), upright, axes, shift, Vec3::UnitZ(), &guess);
      CHECK(o.volume == Approx(volume).epsilon(1e-6));
      CHECK(o.energy == Approx(energy).epsilon(1e-6));
      CHECK((o.force - force * Vec3::UnitZ()).norm() < 1e-6 * force);
      CHECK(std::abs(o.moment.z()) == Approx(couple).epsilon(1e-6).margin(1e-8 * force));
      CHECK(guess.octets == 2);
    }
  }
}
