// SPDX-License-Identifier: LGPL-3.0-or-later
// What a material's bonds are like where two grains are joined: stiffness and strengths.
#pragma once

#include <array>

#include "dem/bond/face_bond.hpp"
#include "dem/rve/model.hpp"

namespace grus::dem {

/// The length that its stiffness goes by (m), of a bond whose grains are so far apart.
double bond_length(const BondModel& model, double apart);

/// Stiffness of a bond between two grains of a material.
void set_stiffness(const BondModel& model, double apart, FaceBond& bond);

/// Stiffness where two materials meet: half of each bond, one behind the other; `depth`: from each grain to the bond
/// (m).
void set_stiffness(const BondModel& a, double depth_a, const BondModel& b, double depth_b, FaceBond& bond);

/// That of two materials whose bond is the weaker. Throws InputError where their criteria differ.
const BondModel& weaker_of(const BondModel& a, const BondModel& b);

/// Strengths of one bond: drawn about the material's, of which it has a share, and no more than its energy lets it
/// soften: `coarse` then. A weaker bond gives way at as much smaller openings: energies go with the square.
void give_strength(const BondModel& model, double share, std::uint64_t seed, std::uint64_t id, double length,
                   FaceBond& bond, bool& coarse);

}  // namespace grus::dem
