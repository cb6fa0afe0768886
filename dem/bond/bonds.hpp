// SPDX-License-Identifier: LGPL-3.0-or-later
// Forces of all bonds. Of a row of its kind it asks (functions beside the kind, found by its type):
//   Pull pull(row, frame, outline)      the force now; the row goes on
//   BondStiffness stiffness(row, frame, outline)  against small motions from here, global: tangents
//   BondStiffness stiffest(row, a)   the same at any time from now on: the time step; a: orientation of the first grain
//   double energy(row)         J, held
//   double dissipated(row)     J, by softening since its birth: never falls
//   double rubbed(row)         J, by friction since its birth: never falls
//   bool broken(row)           it carries nothing any more, and goes
// and the fields `ends`, `force` (on b, N), `at_a`, `at_b` (where it holds on, from each centre of mass, geometry
// frames).
#pragma once

#include <span>

#include "dem/base/parallel.hpp"
#include "dem/state/bonds.hpp"
#include "dem/state/boundary.hpp"
#include "dem/state/grains.hpp"
#include "dem/state/ledger.hpp"

namespace grus::dem {

/// Where the two grains of a bond are; the image is added to x_b.
struct BondFrame {
  const Quat &a, &b;  // geometry -> global
  Vec3 x_a, x_b;      // centres of mass (m)
};

/// Where to find the corners of a bond's face, which only one that softens asks for: kept, or made from the Voronoi
/// cells.
struct FaceOutline {
  const Grains* grains = nullptr;
  std::span<const Eigen::Vector2d> kept = {};
};

struct Pull {
  Vec3 force;                  // on b (N), global; -force on a
  Vec3 arm_a, arm_b;           // from each centre of mass to where it acts (m)
  Vec3 couple = Vec3::Zero();  // on b besides (N m); -couple on a
};

/// Against openings (N/m) and turns (N m) at where a bond acts.
struct BondStiffness {
  Mat3 shift, turn;
};

BondFrame frame_of(const Grains& grains, const Cell& cell, const BondEnds& ends);

/// Velocity of b's image, by the cell's motion (m/s).
Vec3 drag(const Cell& cell, const BondEnds& ends);

/// From the centre of a to that of b, image included (m).
Vec3 branch(const Grains& grains, const Cell& cell, const BondEnds& ends);

/// Evaluates all bonds, writes their force and torque on the grains into grains.force/torque (cleared first), books
/// dissipation and removes the broken ones. `again`: nobody has written there since the last call, which left zero
/// wherever it found no bond. `dt`: since that call, for dashpots (s). The same bits for any number of threads. Returns
/// the power of a moving cell on them (W).
double bond_forces(Grains& grains, const Cell& cell, Bonds& bonds, Ledger& ledger, Team& team, bool again = false,
                   double dt = 0);

/// The same power at the forces that the rows have.
double cell_power(const Cell& cell, const Bonds& bonds);

/// Evaluates the bonds that have been born since each kind had so many as `before` says, adds their force and torque to
/// grains.force/torque and books dissipation. One that has broken carries nothing.
void add_bond_forces(Grains& grains, const Cell& cell, Bonds& bonds, std::span<const std::size_t> before,
                     Ledger& ledger);

/// How many bonds each kind has.
std::vector<std::size_t> counts(const Bonds& bonds);

/// The grains have been put in another order: grain i is now place[i].
void renumber(Bonds& bonds, std::span<const Index> place);

/// Held by all bonds, and by contacts that broken ones have yet to become (J).
double stored_energy(const Bonds& bonds);

}  // namespace grus::dem
