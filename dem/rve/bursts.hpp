// SPDX-License-Identifier: LGPL-3.0-or-later
// Bonds that break together: bursts, their sizes, and the power law that these may follow.
#pragma once

#include <span>
#include <vector>

#include "dem/state/bonds.hpp"

namespace grus::dem {

/// All that has broken in one window of time.
struct Burst {
  double time = 0;  // s, start of the window
  std::size_t bonds = 0;
  double energy = 0, area = 0;  // J, m^2
  Vec3 middle = Vec3::Zero();   // m, weighted by area
};

/// Windows (s) from t = 0 in which something has broken, in order. `broken` is in order of time.
std::vector<Burst> bursts_of(std::span<const BrokenBond> broken, double window);

/// Numbers of bursts of size s as s^-exponent, s = 1 to the largest seen: by maximum likelihood, with its standard
/// error. NaN where all bursts are of one size.
struct PowerLaw {
  double exponent = NAN, error = NAN;
};
PowerLaw fit_power_law(std::span<const Burst> bursts);

}  // namespace grus::dem
