// SPDX-License-Identifier: LGPL-3.0-or-later
// How strong spheres of a lattice are between two platens: what ties a critical stretch to a measured strength.
#pragma once

#include "dem/fracture/lattice_crack.hpp"

namespace grus::dem {

/// F / (E d^2 s_c) at which spheres fail between platens, a mean over so many lattices turned at random, to 1 % each.
/// It depends on number of points, horizon, patch and Poisson's ratio alone: a strength F/d^2 needs the critical
/// stretch strength / (E x this number), at any size. Seconds of a core for some thousand points.
double platen_number(const LatticeModel& model, int lattices = 5);

}  // namespace grus::dem
