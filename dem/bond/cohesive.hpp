// SPDX-License-Identifier: LGPL-3.0-or-later
// Cohesive springs across a fresh fracture plane (Zhang et al. 2015, 3.4.2-3.4.3, mended): each carries its share of
// the initial force, softens linearly to zero, unloads along the secant, never heals, and carries nothing in
// compression.
#pragma once

#include "dem/bond/bonds.hpp"

namespace grus::dem {

/// Traction (N) that is left at the largest opening reached.
inline double remaining_force(const CohesiveSpring& s) {
  if (s.reached >= s.rupture) return 0;
  return s.peak * (s.rupture - s.reached) / (s.rupture - s.onset);
}

inline double secant(const CohesiveSpring& s) { return remaining_force(s) / s.reached; }
inline BondStiffness stiffness(const CohesiveSpring& s, const BondFrame&, const FaceOutline&) {
  return {secant(s) * Mat3::Identity(), Mat3::Zero()};
}
inline BondStiffness stiffest(const CohesiveSpring& s, const Quat&) {
  return {s.peak / s.onset * Mat3::Identity(), Mat3::Zero()};
}
inline bool broken(const CohesiveSpring& s) { return s.reached >= s.rupture; }

/// 0 at birth, exactly peak * rupture / 2 when broken.
inline double dissipated(const CohesiveSpring& s) { return 0.5 * s.rupture * (s.peak - remaining_force(s)); }

inline double rubbed(const CohesiveSpring&) { return 0; }

inline double energy(const CohesiveSpring& s) {
  const double k = secant(s);
  return k > 0 ? 0.5 * s.force.squaredNorm() / k : 0;
}

/// Energy that a spring holds before it has been evaluated for the first time (J).
inline double energy_at_birth(const CohesiveSpring& s) { return 0.5 * s.peak / s.onset * s.preload.squaredNorm(); }

Pull pull(CohesiveSpring& s, const BondFrame& at, const FaceOutline& outline);

}  // namespace grus::dem
