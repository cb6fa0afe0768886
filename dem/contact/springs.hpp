// SPDX-License-Identifier: LGPL-3.0-or-later
// The elastic-plastic spring of a contact, in its plain form: one for the tangential force, and one for each couple.
#pragma once

#include <algorithm>

#include "dem/state/contacts.hpp"

namespace grus::dem {

/// The part of a slip, a turn or a spring that is a row's own: of all so far what lies across the normal n.
[[gnu::always_inline]] inline Vec3 own_part(SpringRow, const Vec3& of, const Vec3& n) { return of - n.dot(of) * n; }

/// The same as a matrix: how a couple's row sees a turn.
inline Mat3 own_turn(SpringRow row, const Vec3& n) {
  Mat3 own;
  for (int j = 0; j < 3; ++j) own.col(j) = own_part(row, Vec3::Unit(j), n);
  return own;
}

/// A spring turned with the contact to the normal n, not shortened. `angle`: of both bodies about n.
[[gnu::always_inline]] inline Vec3 turned_spring(SpringRow row, const Vec3& spring, const Vec3& n, double angle) {
  const double size2 = spring.squaredNorm();
  if (!(size2 > 0)) return spring;
  Vec3 old = own_part(row, spring, n);
  old += angle * n.cross(old);
  const double turned2 = old.squaredNorm();
  if (turned2 > 0) old *= std::sqrt(size2 / turned2);
  return old;
}

/// A spring of the contact goes on by `slip` (m) from `old`, where it is now, at stiffness kt up to `limit`.
[[gnu::always_inline]] inline void advance_spring(Vec3& spring, double compliance, const Vec3& old, const Vec3& slip,
                                                  double kt, double limit, BlockEnergy& e) {
  const double size2 = spring.squaredNorm(), held = 0.5 * compliance * size2;
  const double grown = kt * compliance, after = 1 / kt;
  Vec3 now = std::min(1.0, grown) * old - kt * slip;
  const double size = now.norm();
  // A spring sheds the smaller part of its stiffness or of its force; sliding takes the plastic slip times what held
  // against it, the spring at first and Coulomb's limit at last.
  e.friction += held - std::min(held * grown, 0.5 * size2 * after);
  const double first = std::min(1.0, grown) * std::sqrt(size2);
  if (size > limit) e.friction += 0.5 * (first + limit) * (size - limit) * after, now *= limit / size;
  spring = now;
  e.springs += held - 0.5 * after * now.squaredNorm() - 0.5 * (old + now).dot(slip);
}

}  // namespace grus::dem
