// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls: the gradient of the potential of their overlap (shape/overlap.hpp). The contact's `radius` keeps the modulus
// of the foundation (Pa/m), its `stiffness` is that times the area of contact, as it is now; `overlap` what makes the
// force with it; `reach` the eigenvalue of it alone that the last estimate of the time step has borne (rad^2 s^-2).
#pragma once

#include "dem/contact/law.hpp"

namespace grus::dem {

struct Foundation {
  /// Either the foundation's modulus or that of elasticity over the hulls' depths; all materials of a scene tell the
  /// same.
  struct Of {
    double given = 0;        // Pa/m
    double modulus = 0;      // Pa
    double shear_ratio = 0;  // tangential / normal
  };
  struct Pair {
    double given = 0, modulus = 0;  // Pa/m, Pa

    /// Of depths in all (Pa/m).
    double over(double depth) const { return given > 0 ? given : modulus / depth; }
  };
  static constexpr KernelLaw kernel = KernelLaw::linear;
  static constexpr bool attracts = false, of_hulls = true, stiffens = true;

  Elastic operator()(const Contact& c, double overlap) const { return proportional(c, overlap); }
  static void begin(const Pair&, double, double, Contact&) {}  // the overlap decides: contact/hull_pairs.cpp
  /// Half of the way is in each: they are in series; of a rigid partner the other's.
  static Pair mix(const Partner<Of>& a, const Partner<Of>& b, double& shear_ratio) {
    if (a.rigid() || b.rigid()) {
      const Of& soft = a.rigid() ? b.own : a.own;
      shear_ratio = soft.shear_ratio;
      return {soft.given, soft.modulus};
    }
    shear_ratio = 0.5 * (a.own.shear_ratio + b.own.shear_ratio);
    return {in_series(a.own.given, b.own.given), in_series(a.own.modulus, b.own.modulus)};
  }
  static double hardest_impact(const Pair& p, const Impact& i) {
    return (i.walled || p.given > 0 ? 1 : 0.5) * p.over(i.depth) * 0.25 * i.surface;  // Cauchy: the mean shadow
  }
  static double stiffness_between(const Solid& solid, const Of&, double radius) {
    return 2 * radius * solid.youngs_modulus;
  }
  static double energy_of_strain(const Solid& solid, const Of&, double volume) { return solid.youngs_modulus * volume; }
  static void scale(Of&, double) {}

private:
  static double in_series(double a, double b) { return a + b > 0 ? 2 * a * b / (a + b) : 0; }
};

}  // namespace grus::dem
