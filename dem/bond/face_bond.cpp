// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/bond/face_bond.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

/// Opening and turn of b against a in the axes of the face: e1, e2, normal.
struct Opening {
  Vec3 shift;  // m
  Vec3 half;   // vector part of the turn's quaternion: half the angle (rad)
  double real;

  double open() const { return std::max(shift.z(), 0.0); }
  double shear() const { return shift.head<2>().norm(); }
};

/// Squares of openings, by the energy: k_n A / 2 times them (m^2).
struct Squares {
  double opening, sliding;
  double all() const { return opening + sliding; }
};

Squares squares_of(const FaceBond& s, const Opening& o) {
  const Vec3 angle = 2 * o.half;
  const double bend = s.i1 * angle.x() * angle.x() + s.i2 * angle.y() * angle.y();
  const double twist = (s.i1 + s.i2) * angle.z() * angle.z(), ratio = s.kt / s.kn;
  return {o.open() * o.open() + bend / s.area, ratio * (o.shift.head<2>().squaredNorm() + twist / s.area)};
}

/// Tension of the rim and shear of the rim (Pa), of the undamaged face; the rim of an ellipse of the same moments.
struct Rim {
  double normal, bending, shear;
};

Rim rim_of(const FaceBond& s, const Opening& o) {
  const Vec3 angle = 2 * o.half;
  const double bend = s.i1 * angle.x() * angle.x() + s.i2 * angle.y() * angle.y();
  return {s.kn * o.shift.z(), 2 * s.kn * std::sqrt(bend / s.area),
          s.kt * (o.shear() + 2 * std::abs(angle.z()) * std::sqrt((s.i1 + s.i2) / s.area))};
}

/// 1 and more: the bond gives way.
double utilisation(const FaceBond& s, const Opening& o) {
  if (s.criterion == FaceCriterion::strain_sum)  // tension: the opening, cohesion: the angle
    return (o.open() + o.shear()) / s.tension + 2 * o.half.norm() / s.cohesion;
  const Rim rim = rim_of(s, o);
  const double tension = std::max(rim.normal + rim.bending, 0.0) / s.tension;
  const double shear = rim.shear / (s.cohesion + s.tan_phi * std::max(-rim.normal, 0.0));
  if (s.criterion == FaceCriterion::parallel) return std::max(tension, shear);
  return std::sqrt(tension * tension + shear * shear);
}

void begin_to_soften(FaceBond& s, const Squares& now) {
  const double share = now.sliding / now.all();
  s.onset = s.reached = std::sqrt(now.all());
  s.rupture = 2 * (s.energy_1 + (s.energy_2 - s.energy_1) * share) / (s.kn * s.onset);
}

double damage_at(const FaceBond& s, double reached) {
  if (reached >= s.rupture) return 1;
  return s.rupture * (reached - s.onset) / (reached * (s.rupture - s.onset));
}

/// What softening has taken at an opening (J): half k_n A reached^2 summed over the damage.
double taken_at(const FaceBond& s, double reached) {
  const double until = std::min(reached, s.rupture);
  return 0.5 * s.kn * s.area * s.rupture * s.onset * (until - s.onset) / (s.rupture - s.onset);
}

/// Damage goes on to where the opening has it; returns what it takes (J).
double soften(FaceBond& s, const Opening& o) {
  const Squares now = squares_of(s, o);
  const double whole = 0.5 * s.kn * s.area * now.all();
  if (s.onset == 0) {
    if (utilisation(s, o) < 1) return 0;
    if (s.criterion == FaceCriterion::cohesive) begin_to_soften(s, now);
    if (!(s.rupture > s.onset)) {  // brittle, or more held than it may take
      s.damage = 1;
      return whole;
    }
    return 0;
  }
  const double reached = std::sqrt(now.all());
  if (reached <= s.reached) return 0;
  const double taken = taken_at(s, reached) - taken_at(s, s.reached);
  s.reached = reached, s.damage = damage_at(s, reached);
  return taken;
}

/// The part that has given way sticks and slides under the pressure; its force (N) along e1 and e2. Books what that
/// takes.
Eigen::Vector2d rub(FaceBond& s, const Opening& o, double damage_before) {
  const double kt = s.kt * s.area;
  Eigen::Vector2d slip(s.slip_1, s.slip_2), stretch = o.shift.head<2>() - slip;
  s.spent -= 0.5 * kt * (s.damage - damage_before) * stretch.squaredNorm();  // held on by what has newly given way
  const double limit = s.damage * s.friction * s.kn * s.area * std::max(-o.shift.z(), 0.0);
  const double size = kt * s.damage * stretch.norm();
  if (size > limit) {
    // As advance_spring: slip times what held against it, at first the friction so far and what newly has to slide.
    const double first = std::min(size, s.shear.norm() + kt * (s.damage - damage_before) * stretch.norm());
    s.spent += 0.5 * (first + limit) * (size - limit) / (kt * s.damage);
    stretch *= limit / size, slip = o.shift.head<2>() - stretch;
    s.slip_1 = slip.x(), s.slip_2 = slip.y();
  }
  return -kt * s.damage * stretch;
}

}  // namespace

double softening_limit(double kn, double energy) { return std::sqrt(2 * kn * energy); }

BondStiffness stiffness(const FaceBond& s, const Quat& a) {
  const BondStiffness whole = stiffest(s, a);
  return {(1 - s.damage) * whole.shift, (1 - s.damage) * whole.turn};
}

BondStiffness stiffest(const FaceBond& s, const Quat& a) {
  const Vec3 n = a * s.normal, e1 = a * s.e1, e2 = n.cross(e1);
  return {s.area * ((s.kn - s.kt) * n * n.transpose() + s.kt * Mat3::Identity()),
          s.kn * (s.i1 * e1 * e1.transpose() + s.i2 * e2 * e2.transpose()) + s.kt * (s.i1 + s.i2) * n * n.transpose()};
}

Pull pull(FaceBond& s, const BondFrame& at) {
  const Vec3 arm_b = at.b * s.at_b, to_b = at.x_b + arm_b - at.x_a;
  Mat3 face;  // columns: e1, e2, normal
  face << s.e1, s.normal.cross(s.e1), s.normal;
  const Mat3 axes = at.a.toRotationMatrix() * face;
  const Quat turn = at.a.conjugate() * at.b * s.rest;
  const double sign = turn.w() < 0 ? -1 : 1;
  const Opening o{axes.transpose() * to_b - face.transpose() * s.at_a, sign * (face.transpose() * turn.vec()),
                  sign * turn.w()};
  const double before = s.damage;
  if (!broken(s)) s.spent += soften(s, o);
  const double keep = 1 - s.damage, area = s.area;
  Vec3 force(-keep * s.kt * area * o.shift.x(), -keep * s.kt * area * o.shift.y(),
             -(o.shift.z() > 0 ? keep : 1.0) * s.kn * area * o.shift.z());
  Eigen::Vector2d shear = Eigen::Vector2d::Zero();
  if (s.damage > 0) shear = rub(s, o, before), force.head<2>() += shear;
  const Vec3 resisted = keep * Vec3(s.kn * s.i1, s.kn * s.i2, s.kt * (s.i1 + s.i2)).cwiseProduct(o.half);
  const Vec3 couple = -2 * (o.real * resisted + o.half.cross(resisted));
  const double closed = std::min(o.shift.z(), 0.0);
  s.held = 0.5 * area * (keep * s.kn * squares_of(s, o).all() + s.kn * closed * closed);
  if (s.damage > 0) s.held += 0.5 * shear.squaredNorm() / (s.kt * area * s.damage);
  s.force = axes * force;
  s.shear = axes * Vec3(shear.x(), shear.y(), 0);
  return {s.force, to_b, arm_b, axes * couple};
}

bool bear(FaceBond& s, const Vec3& force, const Vec3& couple) {
  constexpr double most_held = 0.5, least_held = 1e-3, most_stiffer = 4;  // of the energy, of the stiffness
  const auto opening = [&] {
    Opening o{-Vec3(force.x() / (s.kt * s.area), force.y() / (s.kt * s.area), force.z() / (s.kn * s.area)),
              Vec3::Zero(), 1};
    const Vec3 k(s.kn * s.i1, s.kn * s.i2, s.kt * (s.i1 + s.i2));
    for (int n = 0; n < 30; ++n) {  // the couple of small angles, as `pull` has it
      const Vec3 resisted = k.cwiseProduct(o.half);
      o.half = -(0.5 * couple + o.half.cross(resisted)).cwiseQuotient(k) / o.real;
      o.real = std::sqrt(std::max(0.0, 1 - o.half.squaredNorm()));
    }
    return o;
  };
  const double held = 0.5 * s.kn * squares_of(s, opening()).all(), stiffer = held / (most_held * s.energy_1);
  if (stiffer > most_stiffer) {
    s.damage = 1;
    return false;
  }
  if (stiffer > 1) s.kn *= stiffer, s.kt *= stiffer;
  const Opening o = opening();
  Squares now = squares_of(s, o);
  const double least = 2 * least_held * s.energy_1 / s.kn;
  if (now.all() < least) now.opening += least - now.all();
  begin_to_soften(s, now);
  Mat3 face;
  face << s.e1, s.normal.cross(s.e1), s.normal;
  const Vec3 turn = face * o.half;
  s.at_a -= face * o.shift;
  s.rest = (s.rest * Quat(o.real, turn.x(), turn.y(), turn.z())).normalized();
  const double closed = std::min(o.shift.z(), 0.0);
  s.held = 0.5 * s.area * s.kn * (squares_of(s, o).all() + closed * closed);
  return true;
}

Handed handed_by(const FaceBond& s) {
  return {s.ends, s.at_a, s.kn, s.area, s.shear, 1 / (s.kt * s.area), energy(s), s.spent};
}

}  // namespace grus::dem
