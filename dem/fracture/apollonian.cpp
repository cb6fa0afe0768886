// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/apollonian.hpp"

#include <algorithm>

#include "dem/base/random.hpp"

namespace grus::dem {
namespace {

/// Radius of the ball in the six places between: tangent to the mother, to two balls of the equator and to one in whose
/// gap it lies, and to the pole. Newton's steps from nearby, to round-off.
Ball between(const Ball& equator, const Ball& pole) {
  Vec3 x(0.257, -0.594, 0.446);  // radius, y, z
  for (int k = 0; k < 20; ++k) {
    const double r = x[0], y = x[1], z = x[2], up = z - pole.centre.z();
    const Vec3 to(0.5 * std::sqrt(3.0) * equator.centre.y(), y + 0.5 * equator.centre.y(), z);
    const double a = std::hypot(y, z), b = std::hypot(y, up), c = to.norm();
    const Vec3 miss(a + r - 1, b - r - pole.radius, c - r - equator.radius);
    Mat3 slope;
    slope << 1, y / a, z / a, -1, y / b, up / b, -1, to[1] / c, z / c;
    x -= slope.partialPivLu().solve(miss);
  }
  return {x[0], {0, x[1], x[2]}};
}

std::array<Ball, 14> make_balls() {
  const double root3 = std::sqrt(3.0);
  const Ball equator{2 * root3 - 3, {0, 4 - 2 * root3, 0}};
  const double c = equator.centre.y(), r = equator.radius;
  const double at_pole = (1 + c * c - r * r) / (2 * (1 + r));
  const Ball pole{at_pole, {0, 0, 1 - at_pole}};
  // (1 - x)^2 + c^2 - (1 - x) c = (r + x)^2: in the gap between two of the equator, 60 degrees from both.
  const double in_gap = (1 + c * c - c - r * r) / (2 + 2 * r - c);
  const Ball gap{in_gap, {0, in_gap - 1, 0}};
  const Ball upper = between(equator, pole), lower{upper.radius, upper.centre.cwiseProduct(Vec3(1, 1, -1))};
  std::array<Ball, 14> all;
  std::size_t n = 0;
  for (const Ball& first : {equator, gap, upper, lower})
    for (int k = 0; k < 3; ++k) {
      const Eigen::AngleAxisd third(2 * pi * k / 3, Vec3::UnitZ());
      all[n++] = {first.radius, third * first.centre};
    }
  all[n++] = pole;
  all[n++] = {pole.radius, -pole.centre};
  return all;
}

}  // namespace

const std::array<Ball, 14>& fourteen_balls() {
  static const std::array<Ball, 14> balls = make_balls();
  return balls;
}

double kept_volume() {
  double sum = 0;
  for (const Ball& b : fourteen_balls()) sum += b.radius * b.radius * b.radius;
  return sum;
}

double smallest_ball() {
  double least = 1;
  for (const Ball& b : fourteen_balls()) least = std::min(least, b.radius);
  return least;
}

bool can_split(const Balls&, const Grains& g, std::size_t i) { return is_sphere(g, i); }

Pieces pieces_of(const Balls& splitter, const Grains& g, std::size_t i, const Wanted& wanted, std::uint64_t seed) {
  // Where nothing touches, the most compressive direction stands for the load.
  Vec3 axis = wanted.load;
  if (axis.isZero()) axis = principal_axes(wanted.stress).directions.col(0);
  const double turn = 2 * pi * random_uniform(seed, g.id[i], Purpose::turn);
  const Quat frame = Quat::FromTwoVectors(Vec3::UnitZ(), axis) * Quat(Eigen::AngleAxisd(turn, Vec3::UnitZ()));
  const double radius = g.extent[i].equivalent_radius, density = solid_mass(g, i) / g.extent[i].volume;
  Pieces out;
  out.orientation = g.orientation[i];
  for (const Ball& b : fourteen_balls())
    out.piece.push_back({.shape = PolyEllipsoid::sphere(radius * b.radius),
                         .position = g.motion[i].position + radius * (frame * b.centre),
                         .orientation = g.orientation[i],
                         .material = g.material[i],
                         .density = splitter.keep_mass ? density / kept_volume() : density,
                         .turns = g.motion[i].inverse_inertia > 0});
  out.loses_mass = !splitter.keep_mass;
  out.keeps_contacts = false;
  return out;
}

}  // namespace grus::dem
