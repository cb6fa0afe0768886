// SPDX-License-Identifier: LGPL-3.0-or-later
// Supports and loads of Voronoi cells from outside: bonds with walls, which move as they are told, and dead loads.
#pragma once

#include "dem/bond/bonds.hpp"

namespace grus::dem {

/// Where a grain and the wall that it is bonded to are.
BondFrame frame_at_wall(const Grains& grains, const Boundary& boundary, const BondEnds& ends);

/// Clears the forces and torques of the grains that supports write to.
void clear_supported(Grains& grains, const Bonds& bonds);

/// Adds the forces of supports at a time (s) to grains.force and torque and books the work of dead loads since the last
/// call. Returns the power of moving walls on the bonds (W).
double support_forces(Grains& grains, const Boundary& boundary, Bonds& bonds, Ledger& ledger, double time);

/// The same power at the forces that the rows have.
double support_power(const Boundary& boundary, const Bonds& bonds);

/// The force of bonds on a wall (N).
Vec3 support_force(const Bonds& bonds, std::size_t wall);

}  // namespace grus::dem
