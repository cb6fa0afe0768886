// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/bond/cohesive.hpp"

#include <algorithm>

namespace grus::dem {

double stored_energy(const Bonds& bonds) {
  double sum = 0;
  for (const auto& s : bonds) {
    const double stiffness = remaining_force(s) / s.reached;
    if (stiffness > 0) sum += 0.5 * s.force.squaredNorm() / stiffness;
  }
  return sum;
}

void add_bond_forces(Grains& g, Bonds& bonds, std::size_t first, Ledger& ledger) {
  for (std::size_t k = first; k < bonds.size(); ++k) {
    CohesiveSpring& s = bonds[k];
    const Quat &qa = g.orientation[s.a], &qb = g.orientation[s.b];
    const Vec3 arm_a = qa * s.at_a, arm_b = qb * s.at_b, normal = qa * s.normal_a;
    Vec3 w = g.motion[s.b].position + arm_b - g.motion[s.a].position - arm_a + qa * s.preload;
    const double opening = w.dot(normal);
    if (opening < 0) w -= opening * normal;  // compression is the contact's
    const double before = dissipated(s);
    s.reached = std::max(s.reached, w.norm());
    ledger.fracture += dissipated(s) - before;
    s.force = -remaining_force(s) / s.reached * w;
    g.force[s.b] += s.force, g.torque[s.b] += arm_b.cross(s.force);
    g.force[s.a] -= s.force, g.torque[s.a] -= (arm_b + g.motion[s.b].position - g.motion[s.a].position).cross(s.force);
  }
}

void bond_forces(Grains& g, Bonds& bonds, Ledger& ledger, bool again) {
  auto clear = [&](std::size_t i) { g.force[i].setZero(), g.torque[i].setZero(); };
  if (again)
    for (const auto& s : bonds) clear(s.a), clear(s.b);
  else
    for (std::size_t i = 0; i < g.size(); ++i) clear(i);
  add_bond_forces(g, bonds, 0, ledger);
  ledger.bonds_broken += std::erase_if(bonds, [](const CohesiveSpring& s) { return s.reached >= s.rupture; });
}

}  // namespace grus::dem
