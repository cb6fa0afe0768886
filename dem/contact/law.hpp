// SPDX-License-Identifier: LGPL-3.0-or-later
// The words that contact laws share. A law is a type of its own file beside this one; laws.hpp lists them and says what
// a law must answer.
#pragma once

#include <cmath>

#include "dem/kernel/contact_pass.hpp"
#include "dem/state/contacts.hpp"

namespace grus::dem {

/// Response of a contact at an overlap, without dashpot and friction.
struct Elastic {
  double force;             // N, presses where > 0
  double normal_stiffness;  // N/m, slope of the force; below 0 where a contact that is drawn weakens
  double energy;            // J, 0 of a pair that is apart
  double grip;              // N/m, > 0: shear stiffness, dashpot and time step go with it; no less than the slope
  double pull_off = 0;      // N, the largest attraction

  /// What friction counts as normal force (N): Thornton, J. Phys. D 24 (1991) 1942.
  double bears(double normal_force) const { return normal_force + 2 * pull_off; }
};

/// Of a law whose force is the contact's stiffness times the overlap.
inline Elastic proportional(const Contact& c, double overlap) {
  return {c.stiffness * overlap, c.stiffness, 0.5 * c.stiffness * overlap * overlap, c.stiffness};
}

/// A material without its contacts.
struct Solid {
  double youngs_modulus;  // Pa; infinite: rigid
  double poissons_ratio;

  bool rigid() const { return std::isinf(youngs_modulus); }
  double compliance() const { return rigid() ? 0.0 : (1 - poissons_ratio * poissons_ratio) / youngs_modulus; }
  double shear_compliance() const {
    return rigid() ? 0.0 : (2 - poissons_ratio) * 2 * (1 + poissons_ratio) / youngs_modulus;
  }
};

/// One of two that meet: its solid, and what the law asks of its material.
template <class Of>
struct Partner {
  Solid solid;
  Of own;

  bool rigid() const { return solid.rigid(); }
};

/// What a material says of its attraction, and the most at which equal spheres that nothing presses overlap by no more
/// than was asked, both in one unit.
struct Attraction {
  const char *name, *unit;
  double told, most;
};

/// The hardest way in which a grain meets another of its material, or a wall.
struct Impact {
  double mass;    // effective (kg)
  double radius;  // equivalent, of the grain (m)
  double speed;   // m/s
  bool walled;
  double surface = 0, depth = 0;  // of hulls (m^2, m)

  double effective_radius() const { return 0.5 * (radius * (walled ? 2 : 1)); }
};

}  // namespace grus::dem
