// SPDX-License-Identifier: LGPL-3.0-or-later
// The linear law: F = k overlap; k from the materials, or by their modulus K as 2 K D1 D2 / (D1 + D2) = 4 K R_e, frozen
// at birth.
#pragma once

#include "dem/contact/law.hpp"

namespace grus::dem {

struct LinearSpring {
  /// Either a stiffness or a modulus; all materials of a scene tell the same.
  struct Of {
    double stiffness = 0;    // N/m
    double modulus = 0;      // Pa
    double shear_ratio = 0;  // tangential / normal
  };
  struct Pair {
    double stiffness = 0, modulus = 0;  // N/m, Pa
  };
  static constexpr KernelLaw kernel = KernelLaw::linear;
  static constexpr bool attracts = false, of_hulls = false, stiffens = false;

  Elastic operator()(const Contact& c, double overlap) const { return proportional(c, overlap); }
  static void begin(const Pair& p, double effective_radius, double, Contact& c) {
    c.radius = effective_radius, c.stiffness = at_radius(p, effective_radius);
  }
  /// The mean; of a rigid partner the other's.
  static Pair mix(const Partner<Of>& a, const Partner<Of>& b, double& shear_ratio) {
    if (a.rigid() || b.rigid()) {
      const Of& soft = a.rigid() ? b.own : a.own;
      shear_ratio = soft.shear_ratio;
      return {soft.stiffness, soft.modulus};
    }
    shear_ratio = 0.5 * (a.own.shear_ratio + b.own.shear_ratio);
    return {0.5 * (a.own.stiffness + b.own.stiffness), 0.5 * (a.own.modulus + b.own.modulus)};
  }
  static double hardest_impact(const Pair& p, const Impact& i) {
    return at_radius(p, i.radius);  // against something much larger
  }
  static double stiffness_between(const Solid&, const Of& own, double radius) {
    return own.modulus > 0 ? 0.5 * radius * (4 * own.modulus) : own.stiffness;
  }
  static double energy_of_strain(const Solid&, const Of& own, double volume) {
    return own.modulus > 0 ? 4 * own.modulus * volume : own.stiffness * std::pow(volume, 2.0 / 3);
  }
  static void scale(Of&, double) {}

private:
  static double at_radius(const Pair& p, double radius) { return p.modulus > 0 ? 4 * p.modulus * radius : p.stiffness; }
};

}  // namespace grus::dem
