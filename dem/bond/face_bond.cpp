// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/bond/face_bond.hpp"

#include <algorithm>

#include "dem/bond/face_parts.hpp"

namespace grus::dem {
namespace {

/// The corners of a face: those that are kept, or made here.
struct CornersOf {
  FlatPolygon made;
  std::span<const Eigen::Vector2d> corner;

  CornersOf(const FaceBond& s, const FaceOutline& outline) : corner(outline.kept) {
    if (!corner.empty()) return;
    made = outline_of(*outline.grains, s);
    corner = {made.corner.data(), static_cast<std::size_t>(made.corners)};
  }
};

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

double bending_of(const FaceBond& s, const Opening& o) {
  const Vec3 angle = 2 * o.half;
  return (s.i1 * angle.x() * angle.x() + s.i2 * angle.y() * angle.y()) / s.area;
}

double sliding_of(const FaceBond& s, const Opening& o) {
  const double angle = 2 * o.half.z(), twist = (s.i1 + s.i2) * angle * angle;
  return s.kt / s.kn * (o.shift.head<2>().squaredNorm() + twist / s.area);
}

/// Held by the undamaged face (J): all of it, open or pressed, is an elastic foundation.
double held_whole(const FaceBond& s, const Opening& o) {
  const double opening = o.shift.z() * o.shift.z() + bending_of(s, o);
  return 0.5 * s.kn * s.area * (opening + sliding_of(s, o));
}

FaceOpening across(const Opening& o) { return {o.shift.z(), {-2 * o.half.y(), 2 * o.half.x()}}; }

FlatMoments whole_of(const FaceBond& s) {
  FlatMoments m;
  m.area = s.area, m.second.diagonal() << s.i2, s.i1;  // a turn about an axis opens by the distance from it
  return m;
}

/// What softening sees: the open part, and all that slides or twists.
Squares softening_squares(const FaceBond& s, const Opening& o, const FaceParts& parts) {
  return {std::max(parts.of_open.square(across(o)), 0.0) / s.area, sliding_of(s, o)};
}

/// Radius (m) at which the rim twists: of a face that of an ellipse's far ends, of a rod its own.
double rim_radius(const FaceBond& s) {
  return std::sqrt((s.criterion == FaceCriterion::rod ? 2 : 4) * (s.i1 + s.i2) / s.area);
}

/// Tension of the rim and shear of the rim (Pa), of the undamaged face; the rim of an ellipse of the same moments.
struct Rim {
  double normal, bending, shear;
};

Rim rim_of(const FaceBond& s, const Opening& o) {
  return {s.kn * o.shift.z(), 2 * s.kn * std::sqrt(bending_of(s, o)),
          s.kt * (o.shear() + std::abs(2 * o.half.z()) * rim_radius(s))};
}

/// The rim of an ellipse may be at its strength where hardly anything of the true face is open: it then begins to
/// soften at the opening of a tenth of that strength (m^2).
double least_opening(const FaceBond& s, const Opening& o) {
  if (s.criterion != FaceCriterion::cohesive) return 0;
  const Rim rim = rim_of(s, o);
  const double least = 0.1 * std::max(rim.normal + rim.bending, 0.0) / s.kn;
  return least * least;
}

/// 1 and more: the bond gives way.
double utilisation(const FaceBond& s, const Opening& o) {
  if (s.criterion == FaceCriterion::strain_sum)  // tension: the opening, cohesion: the angle
    return (o.open() + o.shear()) / s.tension + 2 * o.half.norm() / s.cohesion;
  const Rim rim = rim_of(s, o);
  const double tension = std::max(rim.normal + rim.bending, 0.0) / s.tension;
  const double shear = rim.shear / (s.cohesion + s.tan_phi * std::max(-rim.normal, 0.0));
  if (s.criterion >= FaceCriterion::parallel) return std::max(tension, shear);
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

/// Damage goes on to where the opening has it; returns what it takes (J). `breaks`: a brittle face has given way, or
/// one that holds more than it may take.
double soften(FaceBond& s, const Squares& now, bool& breaks) {
  if (s.onset == 0) {
    if (s.criterion == FaceCriterion::cohesive) begin_to_soften(s, now);
    if (s.rupture > s.onset) return 0;
    s.damage = 1, breaks = true;
    return 0.5 * s.kn * s.area * now.all();
  }
  const double reached = std::sqrt(now.all());
  if (reached <= s.reached) return 0;
  const double taken = taken_at(s, reached) - taken_at(s, s.reached);
  s.reached = reached, s.damage = damage_at(s, reached);
  return taken;
}

/// The part that has given way sticks and slides on what presses it (N): one spring of three components, along e1, e2
/// and, with the radius of gyration as arm, about the normal, as in a contact. Returns its force on b (N), which was
/// `before`. What newly gives way begins unstretched, so that softening takes all that it held; of a face that breaks
/// at once, with what the face bore, up to the limit.
Vec3 rub(FaceBond& s, const Opening& o, double pressing, const Vec3& before, double damage_before, bool breaks) {
  const double whole = s.kt * s.area, k = whole * s.damage, arm = std::sqrt((s.i1 + s.i2) / s.area);
  const Vec3 reach(o.shift.x(), o.shift.y(), 2 * arm * o.half.z());
  Vec3 stretch = reach - Vec3(s.slip_1, s.slip_2, arm * s.slip_3);
  const double limit = s.friction * s.damage * pressing;
  if (breaks) {
    const double borne = whole * reach.norm();
    stretch = borne > limit ? Vec3(limit / borne * reach) : reach;
    s.spent = std::max(0.0, s.spent - 0.5 * whole * stretch.squaredNorm());  // round-off, where friction bears all
  } else {
    if (s.damage > damage_before && damage_before > 0) {  // the same force, shared by more
      const double less = (1 / damage_before - 1 / s.damage) / whole;
      stretch += less * before;
      s.rubbed += 0.5 * less * before.squaredNorm();
    }
    const double size = k * stretch.norm();
    if (size > limit) {
      // As advance_spring: slip times what held against it, the friction so far at first.
      const double first = std::min(size, before.norm());
      s.rubbed += 0.5 * (first + limit) * (size - limit) / k;
      stretch *= limit / size;
    }
  }
  const Vec3 slip = reach - stretch;
  s.slip_1 = slip.x(), s.slip_2 = slip.y(), s.slip_3 = slip.z() / arm;
  return -k * stretch;
}

/// Force on b, and the couple's parts along e1, e2 and the normal for small turns, in the axes of the face.
struct Resistance {
  Vec3 force, couple;
};

Resistance undamaged(FaceBond& s, const Opening& o) {
  s.held = held_whole(s, o);
  const Vec3 turn(s.kn * s.i1, s.kn * s.i2, s.kt * (s.i1 + s.i2));
  const double kt = s.kt * s.area, kn = s.kn * s.area;
  return {{-kt * o.shift.x(), -kt * o.shift.y(), -kn * o.shift.z()}, -2 * turn.cwiseProduct(o.half)};
}

/// A rod is gone at once, with all that it held.
Resistance parted(FaceBond& s, const Opening& o) {
  s.spent = held_whole(s, o), s.held = 0, s.damage = 1;
  return {Vec3::Zero(), Vec3::Zero()};
}

/// The open part has 1 - damage of its stiffness, what is pressed has all of it.
Resistance damaged(FaceBond& s, const Opening& o, const FaceParts& parts, const Vec3& rubbing, double damage_before,
                   bool breaks) {
  const double keep = 1 - s.damage, area = s.area, polar = s.i1 + s.i2;
  const double pressing = -s.kn * parts.of_pressed.sum;
  const Vec3 shear = rub(s, o, pressing, rubbing, damage_before, breaks);
  const double sum = keep * parts.of_open.sum + parts.of_pressed.sum;
  const Eigen::Vector2d first = keep * parts.of_open.first + parts.of_pressed.first;
  const double twist = -keep * s.kt * polar * 2 * o.half.z() + std::sqrt(polar / area) * shear.z();
  const FaceOpening opening = across(o);
  s.held = 0.5 * s.kn *
               (keep * (parts.of_open.square(opening) + area * sliding_of(s, o)) + parts.of_pressed.square(opening)) +
           0.5 * shear.squaredNorm() / (s.kt * area * s.damage);
  s.shear = shear;
  return {{-keep * s.kt * area * o.shift.x() + shear.x(), -keep * s.kt * area * o.shift.y() + shear.y(), -s.kn * sum},
          {-s.kn * first.y(), s.kn * first.x(), twist}};
}

Mat3 axes_of(const FaceBond& s) {
  Mat3 face;  // columns: e1, e2, normal
  face << s.e1, s.normal.cross(s.e1), s.normal;
  return face;
}

/// `shift`: in the axes of the face.
Opening opened(const FaceBond& s, const BondFrame& at, const Mat3& face, const Vec3& shift) {
  const Quat turn = at.a.conjugate() * at.b * s.rest;
  const double sign = turn.w() < 0 ? -1 : 1;
  return {shift, sign * (face.transpose() * turn.vec()), sign * turn.w()};
}

/// `to_b`: from the centre of a to the middle of the face on b (global).
Opening opening_of(const FaceBond& s, const BondFrame& at, const Mat3& face, const Vec3& to_b) {
  const Mat3 axes = at.a.toRotationMatrix() * face;
  return opened(s, at, face, axes.transpose() * to_b - face.transpose() * s.at_a);
}

/// The couple at any turn, from that of small ones.
Vec3 couple_of(const Resistance& r, const Opening& o) { return o.real * r.couple + o.half.cross(r.couple); }

}  // namespace

double softening_limit(double kn, double energy) { return std::sqrt(2 * kn * energy); }

BondStiffness stiffness(const FaceBond& s, const BondFrame& at, const FaceOutline& outline) {
  if (s.damage == 0) return stiffest(s, at.a);
  const Mat3 face = axes_of(s), axes = at.a.toRotationMatrix() * face;
  const Opening o = opening_of(s, at, face, at.x_b + at.b * s.at_b - at.x_a);
  const FaceParts parts = parts_of(across(o), whole_of(s), CornersOf(s, outline).corner);
  const double keep = 1 - s.damage;
  const double area = keep * s.area + s.damage * parts.pressed.area;
  const Eigen::Matrix2d second = keep * whole_of(s).second + s.damage * parts.pressed.second;
  Mat3 shift = keep * s.kt * s.area * Mat3::Identity(), turn = Mat3::Zero();
  shift(2, 2) = s.kn * area;
  turn(0, 0) = s.kn * second(1, 1), turn(1, 1) = s.kn * second(0, 0), turn(0, 1) = turn(1, 0) = -s.kn * second(0, 1);
  turn(2, 2) = keep * s.kt * (s.i1 + s.i2);
  return {axes * shift * axes.transpose(), axes * turn * axes.transpose()};
}

BondStiffness stiffest(const FaceBond& s, const Quat& a) {
  const Vec3 n = a * s.normal, e1 = a * s.e1, e2 = n.cross(e1);
  return {s.area * ((s.kn - s.kt) * n * n.transpose() + s.kt * Mat3::Identity()),
          s.kn * (s.i1 * e1 * e1.transpose() + s.i2 * e2 * e2.transpose()) + s.kt * (s.i1 + s.i2) * n * n.transpose()};
}

Pull pull(FaceBond& s, const BondFrame& at, const FaceOutline& outline) {
  const Vec3 arm_b = at.b * s.at_b, to_b = at.x_b + arm_b - at.x_a;
  const Mat3 face = axes_of(s), axes = at.a.toRotationMatrix() * face;
  const Opening o = opening_of(s, at, face, to_b);
  Resistance r;
  if (s.onset == 0 && s.damage == 0 && utilisation(s, o) < 1) {
    r = undamaged(s, o);
  } else if (s.criterion == FaceCriterion::rod) {
    r = parted(s, o);
  } else {
    const CornersOf corners(s, outline);
    const FaceParts parts = parts_of(across(o), whole_of(s), corners.corner);
    const double before = s.damage;
    bool breaks = false;
    Squares now = softening_squares(s, o, parts);
    if (s.onset == 0) now.opening = std::max(now.opening, least_opening(s, o));
    if (!broken(s)) s.spent += soften(s, now, breaks);
    r = s.damage > 0 ? damaged(s, o, parts, axes.transpose() * s.shear, before, breaks) : undamaged(s, o);
  }
  s.force = axes * r.force;
  if (s.damage > 0) s.shear = axes * s.shear;
  return {s.force, to_b, arm_b, axes * couple_of(r, o)};
}

Pull pull_of_plate(FaceBond& s, const BondFrame& at) {
  const Vec3 arm_a = at.a * s.at_a, arm_b = at.b * s.at_b;
  const Mat3 face = axes_of(s), axes = (at.b * s.rest).toRotationMatrix() * face;
  const Opening o = opened(s, at, face, axes.transpose() * (at.x_b + arm_b - at.x_a - arm_a));
  const Resistance r = undamaged(s, o);
  s.force = axes * r.force;
  return {s.force, arm_a, arm_b, at.a * Vec3(face * couple_of(r, o))};
}

bool bear(FaceBond& s, const Vec3& force, const Vec3& couple, const FaceOutline& outline) {
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
  const CornersOf corners(s, outline);
  const auto squares = [&](const Opening& o) {
    return softening_squares(s, o, parts_of(across(o), whole_of(s), corners.corner));
  };
  const double stiffer = 0.5 * s.kn * squares(opening()).all() / (most_held * s.energy_1);
  if (stiffer > most_stiffer) {
    s.damage = 1;
    return false;
  }
  if (stiffer > 1) s.kn *= stiffer, s.kt *= stiffer;
  const Opening o = opening();
  Squares now = squares(o);
  const double least = 2 * least_held * s.energy_1 / s.kn;
  if (now.all() < least) now.opening += least - now.all();
  begin_to_soften(s, now);
  const Mat3 face = axes_of(s);
  const Vec3 turn = face * o.half;
  s.at_a -= face * o.shift;
  s.rest = (s.rest * Quat(o.real, turn.x(), turn.y(), turn.z())).normalized();
  s.held = held_whole(s, o);
  return true;
}

Handed handed_by(const FaceBond& s, const BondFrame& at, const FaceOutline& outline) {
  const double fresh = std::isinf(s.tension) ? 0 : s.area;  // the caps of cuts bear without limit until they soften
  const Opening o = opening_of(s, at, axes_of(s), at.x_b + at.b * s.at_b - at.x_a);
  if (s.criterion == FaceCriterion::rod) {
    const double sliding = 0.5 * s.kn * s.area * sliding_of(s, o) / s.spent;
    return {s.ends, s.at_a, 0, s.area, s.area, Vec3::Zero(), 0, 0, s.spent, 0, s.normal, sliding};
  }
  const Squares now = softening_squares(s, o, parts_of(across(o), whole_of(s), CornersOf(s, outline).corner));
  const double sliding = now.all() > 0 ? now.sliding / now.all() : 0;
  return {s.ends, s.at_a, s.kn, s.area, fresh, s.shear, 1 / (s.kt * s.area), energy(s), s.spent, 0, s.normal, sliding};
}

}  // namespace grus::dem
