// SPDX-License-Identifier: LGPL-3.0-or-later
// A material of spheres that break into fourteen.
#pragma once

#include "tests/helpers.hpp"

namespace grus::dem::test {

inline Material crushable(const ContactStrength& strength, double friction = 0) {
  Material m = solid(7.8e9, 0.3, 2650, friction);
  m.fracture = FractureModel{};
  m.fracture->criteria.emplace_back(strength);
  m.fracture->splitter = Balls{};
  return m;
}

}  // namespace grus::dem::test
