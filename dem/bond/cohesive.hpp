// SPDX-License-Identifier: LGPL-3.0-or-later
// Cohesive springs across a fresh fracture plane (Zhang et al. 2015, 3.4.2-3.4.3, mended): each carries its share of
// the initial force, softens linearly to zero, unloads along the secant, never heals, and carries nothing in
// compression.
#pragma once

#include "dem/state/bonds.hpp"
#include "dem/state/grains.hpp"
#include "dem/state/ledger.hpp"

namespace grus::dem {

/// Traction (N) that is left at the largest opening reached.
inline double remaining_force(const CohesiveSpring& s) {
  if (s.reached >= s.rupture) return 0;
  return s.peak * (s.rupture - s.reached) / (s.rupture - s.onset);
}

/// Energy dissipated so far (J): 0 at birth, exactly peak * rupture / 2 when broken.
inline double dissipated(const CohesiveSpring& s) { return 0.5 * s.rupture * (s.peak - remaining_force(s)); }

/// Stored energy (J) at the present opening.
double stored_energy(const Bonds& bonds);

/// Evaluates the springs from `first` on and adds their force and torque to grains.force/torque; books dissipation. One
/// that has broken carries nothing.
void add_bond_forces(Grains& grains, Bonds& bonds, std::size_t first, Ledger& ledger);

/// Evaluates all springs, writes their force and torque on the grains into grains.force/torque (cleared first), books
/// dissipation and removes the broken ones. `again`: nobody has written there since the last call, which left zero
/// wherever it found no spring.
void bond_forces(Grains& grains, Bonds& bonds, Ledger& ledger, bool again = false);

}  // namespace grus::dem
