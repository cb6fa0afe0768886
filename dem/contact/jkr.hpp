// SPDX-License-Identifier: LGPL-3.0-or-later
// Spheres whose surfaces attract: Johnson, Kendall & Roberts, Proc. R. Soc. Lond. A 324 (1971) 301. A circle of radius
// a presses with F = 4 E* a^3 / (3 R_e) - sqrt(8 pi W E* a^3) at the overlap a^2 / R_e - sqrt(2 pi W a / E*), W the
// work of adhesion. A pair snaps on where its surfaces meet, and holds until the overlap is -3 unit, unit = a_c^2 /
// R_e, a_c^3 = pi W R_e^2 / (8 E*). With k = 4/3 E* sqrt(R_e) and s = sqrt(a / a_c) >= 1 all is
//   overlap = unit (s^4 - 4 s), force = k unit^1.5 s^3 (s^3 - 6), energy = k unit^2.5 s^4 (0.4 s^6 - 4 s^3 + 6),
// the energy with that of the surfaces, 0 of a pair that is apart; pull-off is 3/2 pi W R_e = 9 k unit^1.5.
#pragma once

#include <algorithm>

#include "dem/base/tensor.hpp"
#include "dem/contact/hertz_mindlin.hpp"

namespace grus::dem {

struct Jkr {
  struct Of {
    double work = 0;  // of adhesion, between two surfaces of the material (J/m^2)
  };
  struct Pair {
    double youngs = 0, work = 0;  // E* (Pa), J/m^2
  };
  static constexpr KernelLaw kernel = KernelLaw::jkr;
  static constexpr bool attracts = true, of_hulls = false, stiffens = true;

  Elastic operator()(const Contact& c, double overlap) const {
    const double u = unit(c, overlap), k = c.stiffness * u * std::sqrt(u), s = root_of_radius(overlap / u);
    const double q = s * s * s, grip = 1.5 * c.stiffness * std::sqrt(u) * s * s;
    return {k * q * (q - 6), grip * (q - 3) / std::max(q - 1, 1e-6), k * u * q * s * (0.4 * q * q - 4 * q + 6), grip,
            9 * k};
  }
  static void begin(const Pair& p, double effective_radius, double ellipse, Contact& c) {
    HertzMindlin::begin({p.youngs}, effective_radius, ellipse, c);
    if (p.work > 0) c.reach = 3 * std::cbrt(std::pow(pi * p.work / (8 * p.youngs), 2) * effective_radius);
  }
  /// The geometric mean; of a rigid partner the other's.
  static Pair mix(const Partner<Of>& a, const Partner<Of>& b, double& shear_ratio) {
    const double youngs = HertzMindlin::mix({a.solid, {}}, {b.solid, {}}, shear_ratio).youngs;
    if (a.rigid() || b.rigid()) return {youngs, a.rigid() ? b.own.work : a.own.work};
    return {youngs, std::sqrt(a.own.work * b.own.work)};
  }
  /// Energy that is lost as the surfaces meet, at no overlap and s^3 = 4 (J).
  static double snap_on(const Contact& c) { return 3.6 * 4 * std::cbrt(4.0) * scale_of_energy(c); }
  /// Energy that is lost as they part, at s = 1 (J).
  static double snap_off(const Contact& c) { return 2.4 * scale_of_energy(c); }

  /// A bound: s^4 (0.4 s^6 - 4 s^3 + 6) > 0.4 (s^3 - 10)^(10/3), which is the energy of the impact.
  static double hardest_impact(const Pair& p, const Impact& i) {
    const double hertz = HertzMindlin::hardest_impact({p.youngs}, i);
    Contact c;
    begin(p, i.effective_radius(), 1, c);
    if (!(c.reach > 0)) return hertz;
    const double least = 1.5 * c.stiffness * std::sqrt(c.reach / 3);  // of s = 1
    return least * std::pow(10 + std::pow(hertz / least, 1.5), 2.0 / 3);
  }
  static double stiffness_between(const Solid& solid, const Of&, double radius) {
    return 2 * radius * solid.youngs_modulus;
  }
  static double energy_of_strain(const Solid& solid, const Of&, double volume) { return solid.youngs_modulus * volume; }
  /// Overlaps are the same part of a radius where W / (E R) is the same.
  static void scale(Of& of, double factor) { of.work *= factor; }

  static Attraction attraction(const Solid& solid, const Of& of, double radius, double part) {
    return {"work_of_adhesion", "J/m^2", of.work, work_at(solid, radius, part)};
  }
  /// Work of adhesion at which two equal spheres that nothing presses overlap by `part` of their radius (J/m^2): at
  /// F = 0, s^3 = 6.
  static double work_at(const Solid& solid, double radius, double part) {
    const double youngs = 0.5 / solid.compliance();
    return 8 * youngs / pi * std::sqrt(std::pow(part * radius / (2 * std::cbrt(6.0)), 3) / (0.5 * radius));
  }

private:
  /// Surfaces that hardly attract press as Hertz has it.
  static double unit(const Contact& c, double overlap) { return std::max({c.reach / 3, 1e-20 * overlap, 1e-250}); }
  static double scale_of_energy(const Contact& c) {
    const double u = c.reach / 3;
    return c.stiffness * u * u * std::sqrt(u);
  }
  /// s of s^4 - 4 s = d, the larger one: of (s - 1) sqrt(6 + 4 (s - 1) + (s - 1)^2) = sqrt(d + 3) by Newton, from
  /// above; as in kernel/jkr_row.hpp.
  static double root_of_radius(double d) {
    const double t = std::sqrt(std::max(d + 3, 0.0));
    double v = t / (1 + std::sqrt(1 + t));
    for (int n = 0; n < 4; ++n) {
      const double square = 6 + v * (4 + v), h = std::sqrt(square);
      v -= (v * h - t) * h / (square + v * (2 + v));
    }
    return 1 + v;
  }
};

}  // namespace grus::dem
