// SPDX-License-Identifier: LGPL-3.0-or-later
// Dashpots of face bonds: each of the five modes of a face has the same fraction of its critical damping, of what has
// not given way.
#pragma once

#include "dem/bond/bonds.hpp"

namespace grus::dem {

/// The dashpot of a bond between two grains; `fraction` of critical.
FaceDashpot dashpot_of(const FaceBond& bond, const Grains& grains, double fraction);

/// Adds the dashpot's force and couple to the bond's. `dt`: since the last call (s). Returns what it has taken (J).
double resist(const Grains& grains, const Cell& cell, FaceBond& bond, FaceDashpot& dashpot, double dt, Pull& pull);

/// Resistances to the velocities of openings (N s/m) and turns (N m s), global; a: orientation of the first grain.
BondStiffness resistance(const FaceBond& bond, const FaceDashpot& dashpot, const Quat& a);

}  // namespace grus::dem
