// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/cleavage.hpp"

#include <algorithm>

#include "dem/fracture/hull_loads.hpp"

namespace grus::dem {
namespace {

/// Longer than this over its width, a grain may break by being bent.
constexpr double slender = 3;

struct Traction {
  double tension, shear;  // largest on the section (Pa); pressure is no tension
};

/// Linear over the section: what bends it and what twists it is largest at a corner.
Traction traction_on(const PlaneLoad& load, const Vec3& normal, const Mat3& axes) {
  const std::array<Vec3, 2> e = across(axes.transpose() * normal);
  const Vec3 e1 = axes * e[0], e2 = axes * e[1];
  const FlatMoments& m = load.moments;
  const Eigen::Vector2d middle = m.first / m.area;
  const Eigen::Matrix2d second = m.second - m.area * middle * middle.transpose();
  const Eigen::Vector2d slope = second.inverse() * Eigen::Vector2d(load.moment.dot(e2), -load.moment.dot(e1));
  double bending = 0, rim = 0;
  for (int k = 0; k < load.section.corners; ++k) {
    const Eigen::Vector2d y = load.section.corner[static_cast<std::size_t>(k)] - middle;
    bending = std::max(bending, slope.dot(y)), rim = std::max(rim, y.norm());
  }
  const double along = load.force.dot(normal);
  const double across_it = (load.force - along * normal).norm();
  return {std::max(0.0, bending - along / m.area),
          across_it / m.area + std::abs(load.moment.dot(normal)) * rim / second.trace()};
}

struct Candidate {
  Vec3 normal;  // global
  double toughness;
};

/// At most as many as a crystal has families of planes, or three.
template <class F>
void each_candidate(const Cleavage& c, const LoadedHull& grain, const Mat3& principal, F&& f) {
  if (c.planes.empty()) {  // columns: least to most tensile
    const Vec3 low = principal.col(0), high = principal.col(2);
    for (const Vec3& n : {high, Vec3((high + low).normalized()), Vec3((high - low).normalized())})
      f(Candidate{n, c.toughness});
    return;
  }
  const Mat3 axes = grain.crystal_axes();
  for (const Cleavage::Plane& p : c.planes) f(Candidate{axes * p.normal, p.toughness});
}

}  // namespace

Cleft Cleavage::worst(const LoadedHull& grain, double factor) const {
  const auto [s, directions] = principal_axes(grain.stress());
  if (gate && !(s.sum() > 3 * *gate)) return {};
  double weakest = planes.empty() ? toughness : INFINITY;
  for (const Plane& p : planes) weakest = std::min(weakest, p.toughness);
  const double root = geometry * std::sqrt(pi * flaw);
  const auto needed = [&](double k) { return factor * k / root; };  // the tension that opens (Pa)
  // A slender grain is bent by loads whose stress has no mean.
  const double bent = grain.slenderness() > slender ? std::pow(grain.slenderness(), 2) * grain.load_density() : 0;
  const double most =
      mixed_mode(std::max({0.0, s[2], bent}) / needed(weakest), 0.5 * (s[2] - s[0]) / (mode_ratio * needed(weakest)));
  if (most < worth_a_look) return {most, Vec3::Zero(), 0, 0, 0};
  Cleft found;
  each_candidate(*this, grain, directions, [&](const Candidate& c) {
    for (const double place : offsets) {
      const double offset = place < 0 ? place * grain.reach(-c.normal) : place * grain.reach(c.normal);
      const PlaneLoad load = grain.across_plane(c.normal, offset);
      if (load.share < least_share) continue;
      const Traction t = traction_on(load, c.normal, grain.axes());
      const double now = mixed_mode(t.tension / needed(c.toughness), t.shear / (mode_ratio * needed(c.toughness)));
      if (now > found.utilisation) found = {now, c.normal, offset, t.tension, t.shear};
    }
  });
  return found;
}

}  // namespace grus::dem
