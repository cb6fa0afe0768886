// SPDX-License-Identifier: LGPL-3.0-or-later
// How strong spheres of a lattice are between two platens.
#pragma once

#include <cmath>
#include <optional>

#include "dem/fracture/lattice_crack.hpp"

namespace grus::dem {

/// F / (E d^2 s) at which a sphere breaks between two platens, F the force and s the critical stretch: a number of the
/// lattice alone, the mean of four to six orientations (docs/physics/peridynamics.md). Known of the horizon of 2.5
/// spacings with partial volumes and of 3 without; it falls slowly with the number of points.
inline std::optional<double> platen_factor(const LatticeModel& model) {
  const LatticeChoice& lattice = model.lattice;
  const double finer = std::log(lattice.points / 2272.0);
  if (lattice.horizon == 2.5 && lattice.partial_volume)
    return model.keep_patches ? 0.607 * std::exp(-0.055 * finer) : 0.600 * std::exp(-0.052 * finer);
  if (lattice.horizon == 3 && !lattice.partial_volume) return 0.572 * std::exp(-0.077 * finer);
  return std::nullopt;
}

}  // namespace grus::dem
