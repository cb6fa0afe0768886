// SPDX-License-Identifier: LGPL-3.0-or-later
// Private to fem: what a rank's materials hold and have spent, as a part of a sum over all ranks.
#pragma once

#include "fem/problem_impl.hpp"

namespace grus::fem {

/// Throws std::invalid_argument for a material that has no energies point by point where sums are exact.
inline void need_energies(const Problem::Impl& p, const Material& material) {
  if (p.discretisation.exact_sums && !material.energies)
    throw std::invalid_argument("exact sums need a material that tells the energy of each point");
}

/// Adds the energy (J) of the material at points of these volumes (m^3). `each`: room for the points' own.
inline void add_energy(const Material& material, std::span<const double> volumes, std::vector<double>&, double& sum) {
  sum += material.energy(volumes);
}
inline void add_energy(const Material& material, std::span<const double> volumes, std::vector<double>& each,
                       ExactSum& sum) {
  each.resize(volumes.size());
  material.energies(volumes, each);
  for (const double e : each) sum += e;
}

}  // namespace grus::fem
