// SPDX-License-Identifier: LGPL-3.0-or-later
// The contact that is deepest for its size.
#pragma once

#include <algorithm>

#include "dem/state/contacts.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// Of a pair's grains, the smaller equivalent radius (m); at a wall the grain's.
inline double smaller_radius(const Grains& g, const Pair& p, bool walled) {
  const double of_a = g.extent[p.a].equivalent_radius;
  return walled ? of_a : std::min(of_a, g.extent[p.b].equivalent_radius);
}

/// Largest overlap relative to the smaller equivalent radius, and the pair that has it.
struct DeepestContact {
  double ratio = 0;
  std::size_t pair = 0;
};
DeepestContact deepest_contact(const Grains& grains, const Contacts& contacts);

}  // namespace grus::dem
