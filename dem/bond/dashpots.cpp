// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/bond/dashpots.hpp"

namespace grus::dem {
namespace {

double parallel(double x, double y) { return x * y / (x + y); }

Mat3 axes_of(const FaceBond& s, const Quat& a) {
  Mat3 axes;  // columns: e1, e2, normal
  axes << s.e1, s.normal.cross(s.e1), s.normal;
  return a.toRotationMatrix() * axes;
}

}  // namespace

FaceDashpot dashpot_of(const FaceBond& s, const Grains& g, double fraction) {
  const Mat3 axes = axes_of(s, g.orientation[s.ends.a]);
  const double mass = parallel(g.mass[s.ends.a], g.mass[s.ends.b]);
  const Mat3 of_a = inertia_tensor(g, s.ends.a), of_b = inertia_tensor(g, s.ends.b);
  const double turn[] = {s.kn * s.i1, s.kn * s.i2, s.kt * (s.i1 + s.i2)};
  FaceDashpot d;
  d.normal = 2 * fraction * std::sqrt(s.kn * s.area * mass);
  d.shear = 2 * fraction * std::sqrt(s.kt * s.area * mass);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vec3 e = axes.col(k);
    d.turn[k] = 2 * fraction * std::sqrt(turn[k] * parallel(e.dot(of_a * e), e.dot(of_b * e)));
  }
  return d;
}

double resist(const Grains& g, const Cell& cell, FaceBond& s, FaceDashpot& d, double dt, Pull& p) {
  const Motion &a = g.motion[s.ends.a], &b = g.motion[s.ends.b];
  const Vec3 velocity = b.velocity + b.spin.cross(p.arm_b) + drag(cell, s.ends) - a.velocity - a.spin.cross(p.arm_a);
  const Vec3 spin = b.spin - a.spin;
  const BondStiffness c = resistance(s, d, g.orientation[s.ends.a]);
  const Vec3 force = -(c.shift * velocity), couple = -(c.turn * spin);
  // What held before the step and what holds after it each do half: so do the grains' kicks.
  const double taken = -0.5 * dt * ((d.force + force).dot(velocity) + (d.couple + couple).dot(spin));
  d.force = force, d.couple = couple;
  p.force += force, p.couple += couple, s.force += force;
  return taken;
}

BondStiffness resistance(const FaceBond& s, const FaceDashpot& d, const Quat& a) {
  const Mat3 axes = axes_of(s, a);
  const double keep = 1 - s.damage;
  const auto turned = [&](const Vec3& along) -> Mat3 { return keep * axes * along.asDiagonal() * axes.transpose(); };
  return {turned({d.shear, d.shear, d.normal}), turned(d.turn)};
}

}  // namespace grus::dem
