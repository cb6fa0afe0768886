// SPDX-License-Identifier: LGPL-3.0-or-later
// Hertz and Mindlin: F = k overlap^1.5, k = 4/3 E* sqrt(R_e) with R_e frozen at contact birth.
#pragma once

#include <algorithm>

#include "dem/contact/law.hpp"

namespace grus::dem {

struct HertzMindlin {
  struct Of {};  // the solid says all
  struct Pair {
    double youngs = 0;  // E* = [(1-nu1^2)/E1 + (1-nu2^2)/E2]^-1 (Pa)
  };
  static constexpr KernelLaw kernel = KernelLaw::hertz;
  static constexpr bool attracts = false, of_hulls = false, stiffens = true;

  Elastic operator()(const Contact& c, double overlap) const {
    const double ks = c.stiffness * std::sqrt(overlap);
    return {ks * overlap, 1.5 * ks, 0.4 * ks * overlap * overlap, 1.5 * ks};
  }
  static void begin(const Pair& p, double effective_radius, double ellipse, Contact& c) {
    c.radius = effective_radius;
    c.stiffness = 4.0 / 3 * p.youngs * std::sqrt(effective_radius) * ellipse;
  }
  static Pair mix(const Partner<Of>& a, const Partner<Of>& b, double& shear_ratio) {
    const double c = a.solid.compliance() + b.solid.compliance();
    const double s = a.solid.shear_compliance() + b.solid.shear_compliance();
    if (!(c > 0)) return {};
    shear_ratio = 4 * c / s;  // 4 G*/E*
    return {1 / c};
  }
  static double hardest_impact(const Pair& p, const Impact& i) {
    const double e = p.youngs > 0 ? p.youngs : 1;
    const double depth =
        std::max(std::pow(15 * i.mass * i.speed * i.speed / (16 * std::sqrt(i.effective_radius()) * e), 0.4),
                 1e-4 * (i.radius * (i.walled ? 2 : 1)));
    return 2 * e * std::sqrt(i.effective_radius() * depth);
  }
  static double stiffness_between(const Solid& solid, const Of&, double radius) {
    return 2 * radius * solid.youngs_modulus;
  }
  static double energy_of_strain(const Solid& solid, const Of&, double volume) { return solid.youngs_modulus * volume; }
  static void scale(Of&, double) {}
};

}  // namespace grus::dem
