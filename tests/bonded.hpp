// SPDX-License-Identifier: LGPL-3.0-or-later
// Rock of bonded cells for the tests.
#pragma once

#include "dem/bond/kinds.hpp"
#include "tests/helpers.hpp"

namespace grus::dem::test {

inline constexpr double E0 = 1e9, density = 2000;

inline Model rock(const BondModel& bond, double friction = 0) {
  Model model;
  Material m = solid(E0, 0, density, friction), rigid;
  m.name = "rock", m.bond = bond;
  m.contact = Foundation::Of{.modulus = E0, .shear_ratio = bond.ratio};
  rigid.youngs_modulus = INFINITY, rigid.friction = NAN;
  model.law = Foundation{};
  model.materials = {m, rigid};
  make_pair_laws(model);
  return model;
}

inline BondModel elastic(double ratio = 1) {
  BondModel b;
  b.stiffness = E0, b.ratio = ratio;
  return b;
}

inline BondModel cohesive(double tension, double energy) {
  BondModel b = elastic(0.5);
  b.tension = tension, b.cohesion = 2 * tension, b.tan_phi = 0.6, b.energy_1 = energy, b.energy_2 = 3 * energy;
  return b;
}

}  // namespace grus::dem::test
