// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/wall_force.hpp"

#include "dem/bond/supports.hpp"
#include "dem/rve/rough_walls.hpp"

namespace grus::dem {

Vec3 wall_force(const State& s, std::size_t wall) {
  Vec3 force = Vec3::Zero();
  for (std::size_t k = s.contacts.begin[first_wall]; k < s.contacts.size(); ++k)
    if (s.contacts.pair[k].b == wall) force += s.contacts.touch[k].force;
  return force + support_force(s.bonds, wall) + rough_force(s, wall);
}

}  // namespace grus::dem
