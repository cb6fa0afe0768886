// SPDX-License-Identifier: LGPL-3.0-or-later
// Inertia by each grain's own step: grains that a wanted time step is too long for resist shifts, or turns, by as much
// more as they need. Quasi-static motion alone.
#pragma once

#include "dem/motion/grain_stiffness.hpp"

namespace grus::dem {

struct GivenInertia {
  double kinetic = 0;  // J, put in: what gains mass keeps its momentum, what loses some its velocity
  double rise = 1;     // the largest factor by which a mass rose that had been enough
};

/// Masses of shifts and of turns, apart, of every grain whose eigenvalue is above `most` (1/s^2), raised until it is
/// not; the motion that is too fast says which of them by how much. What gains mass keeps its momentum against the
/// cell's own motion, and what gains moments its angular momentum. A hull that something touches falls to what its
/// contacts and impacts ask for once half of what it has would do; all others count impacts, and keep what they have.
/// `floor`: by grain the least mass (kg), of either. `held` is of the same grains.
GivenInertia give_inertia(const HeldGrains& held, double most, const std::vector<double>& floor, Grains& grains);

/// What it has added, over the grains as solids.
struct AddedInertia {
  double mass = 0, moment = 0;     // of all grains, over the masses and moments (traces) of the solids
  double heavier = 0, slower = 0;  // shares of the grains that have more mass, larger moments
};
AddedInertia added_inertia(const Grains& grains);

/// The largest of the grains' own inertial numbers, rate x diameter x sqrt(mass / (volume x pressure)).
double largest_inertial_number(const Grains& grains, double rate, double pressure);

}  // namespace grus::dem
