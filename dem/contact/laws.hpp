// SPDX-License-Identifier: LGPL-3.0-or-later
// Contact laws as values with a call operator; each sees one contact and nothing else.
#pragma once

#include <variant>

#include "dem/state/contacts.hpp"

namespace grus::dem {

/// Constants of a pair of materials (or grain and wall).
struct PairLaw {
  double youngs = 0;    // E* = [(1-nu1^2)/E1 + (1-nu2^2)/E2]^-1 (Pa)
  double shear_ratio = 0;  // tangential / normal tangent stiffness; Hertz-Mindlin: 4 G*/E*
  double friction = 0;
  double dashpot = 0;   // coefficient c in c sqrt(m* S_n), S_n the tangent normal stiffness
  double normal_stiffness = 0;  // linear law (N/m)
};

/// Elastic response of a contact at an overlap.
struct Elastic {
  double force, normal_stiffness, energy;  // N, tangent N/m, J
};

/// F = k overlap^1.5, k = 4/3 E* sqrt(R_e) with R_e frozen at contact birth.
struct HertzMindlin {
  Elastic operator()(double stiffness, double overlap) const {
    const double ks = stiffness * std::sqrt(overlap);
    return {ks * overlap, 1.5 * ks, 0.4 * ks * overlap * overlap};
  }
  double stiffness_at_birth(const PairLaw& p, double effective_radius) const {
    return 4.0 / 3 * p.youngs * std::sqrt(effective_radius);
  }
};

/// F = k overlap.
struct LinearSpring {
  Elastic operator()(double stiffness, double overlap) const {
    return {stiffness * overlap, stiffness, 0.5 * stiffness * overlap * overlap};
  }
  double stiffness_at_birth(const PairLaw& p, double) const { return p.normal_stiffness; }
};

using ContactLaw = std::variant<HertzMindlin, LinearSpring>;

/// Advances a touching contact to the new normal and overlap; returns the force on b.
/// Tangential form: incremental dF = -k_t dslip, rescaled by k_t/k_t,old on unloading so that no energy appears.
/// `v`: velocity of b against a at the contact point; `twist`: mean spin of both along n. Energies are booked to `e`:
/// trapezoid of force times the half-step velocity, the discrete work of the leapfrog integrator.
template <class Law>
[[gnu::always_inline]] inline Vec3 advance_contact(const Law& law, const PairLaw& p, Contact& c, const Vec3& n, double overlap, const Vec3& v,
                            double twist, double dt, BlockEnergy& e) {
  const Elastic elastic = law(c.stiffness, overlap);
  const double vn = v.dot(n);
  double viscous = 0;
  if (p.dashpot > 0) {
    viscous = -p.dashpot * std::sqrt(c.effective_mass * elastic.normal_stiffness) * vn;
    if (elastic.force + viscous < 0) viscous = -elastic.force;  // no attraction
    e.viscous -= 0.5 * (c.viscous + viscous) * vn * dt;
    c.viscous = viscous;
  }
  c.overlap = overlap;
  const double normal_force = elastic.force + viscous;
  if (p.friction == 0) {
    c.normal = n;
    return normal_force * n;
  }
  const double kt = p.shear_ratio * elastic.normal_stiffness;
  const double size2 = c.spring.squaredNorm();
  Vec3 old = c.spring;
  if (size2 > 0) {
    old -= n * n.dot(old);
    old += (twist * dt) * n.cross(old);
    const double turned2 = old.squaredNorm();
    if (turned2 > 0) old *= std::sqrt(size2 / turned2);  // turned with the contact, not shortened
  }
  const Vec3 slip = dt * (v - vn * n);
  Vec3 now = (kt < c.tangential ? kt / c.tangential : 1.0) * old - kt * slip;
  const double limit = p.friction * normal_force, now2 = now.squaredNorm();
  if (now2 > limit * limit) now *= limit / std::sqrt(now2);
  const double remains = kt > 0 ? 0.5 * now.squaredNorm() / kt : 0;
  e.friction += c.shear_energy - remains - 0.5 * (old + now).dot(slip);
  c.spring = now;
  c.tangential = kt;
  c.shear_energy = remains;
  c.normal = n;
  return normal_force * n + now;
}

/// Books what a parting contact still holds, and forgets it.
inline void part_contact(Contact& c, BlockEnergy& e) {
  e.friction += c.shear_energy;
  c.stiffness = c.overlap = c.tangential = c.shear_energy = c.viscous = c.radius = 0;
  c.spring.setZero();
}

/// Elastic energy of a contact, normal and tangential (J).
template <class Law>
inline double elastic_energy(const Law& law, const Contact& c) {
  if (c.stiffness <= 0) return 0;
  return law(c.stiffness, c.overlap).energy + c.shear_energy;
}

/// Elastic part of the normal force of a touching contact (N).
inline double elastic_force(const ContactLaw& law, const Contact& c) {
  return std::visit([&](const auto& l) { return l(c.stiffness, c.overlap).force; }, law);
}

/// Dashpot coefficient that makes the measured restitution of a head-on impact equal `restitution`, the force being
/// cut at zero attraction. The textbook value without the cut gives 0.472 for 0.4 (Hertz).
double dashpot_for(const ContactLaw& law, double restitution);

/// Restitution that an impact shows with a dashpot coefficient (numerical integration, dimensionless).
double restitution_of(const ContactLaw& law, double dashpot);

}  // namespace grus::dem
