// SPDX-License-Identifier: LGPL-3.0-or-later
// Contact laws as values with a call operator; each sees one contact and nothing else.
#pragma once

#include <algorithm>
#include <variant>

#include "dem/state/contacts.hpp"

namespace grus::dem {

/// Constants of a pair of materials (or grain and wall).
struct PairLaw {
  double youngs = 0;       // E* = [(1-nu1^2)/E1 + (1-nu2^2)/E2]^-1 (Pa)
  double shear_ratio = 0;  // tangential / normal tangent stiffness; Hertz-Mindlin: 4 G*/E*
  double friction = 0;
  double rolling = 0;  // largest rolling couple / (normal force x effective radius); 0 where nothing slides
  double dashpot = 0;  // coefficient c in c sqrt(m* S_n), S_n the tangent normal stiffness
  // Linear law (N/m); by modulus: of an effective radius of 1 m (Pa); of hulls: modulus of elasticity (Pa), or of the
  // foundation (Pa/m).
  double normal_stiffness = 0;
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

/// F = k overlap; k from the materials, or by their modulus K as 2 K D1 D2 / (D1 + D2) = 4 K R_e, frozen at birth.
struct LinearSpring {
  bool by_modulus = false;

  Elastic operator()(double stiffness, double overlap) const {
    return {stiffness * overlap, stiffness, 0.5 * stiffness * overlap * overlap};
  }
  double stiffness_at_birth(const PairLaw& p, double effective_radius) const {
    return by_modulus ? p.normal_stiffness * effective_radius : p.normal_stiffness;
  }
};

/// Hulls: the gradient of the potential of their overlap (shape/overlap.hpp). The contact's `radius` keeps the modulus
/// of the foundation (Pa/m), its `stiffness` is that times the area of contact, as it is now; `overlap` what makes the
/// force with it. The modulus is given, or a modulus of elasticity (Pa) over the hulls' depths.
struct Foundation {
  bool given = false;

  Elastic operator()(double stiffness, double overlap) const {
    return {stiffness * overlap, stiffness, 0.5 * stiffness * overlap * overlap};
  }
  double stiffness_at_birth(const PairLaw& p, double) const { return p.normal_stiffness; }
};

using ContactLaw = std::variant<HertzMindlin, LinearSpring, Foundation>;

/// Force of the dashpot along n (N), at the approach speed -vn; no attraction.
[[gnu::always_inline]] inline double advance_dashpot(const PairLaw& p, double effective_mass, const Elastic& elastic,
                                                     double vn, double dt, Contact& c, BlockEnergy& e) {
  if (!(p.dashpot > 0)) return 0;
  const double viscous =
      std::max(-p.dashpot * std::sqrt(effective_mass * elastic.normal_stiffness) * vn, -elastic.force);
  e.viscous -= 0.5 * (c.viscous + viscous) * vn * dt;
  c.viscous = viscous;
  return viscous;
}

/// A spring turned with the contact to the normal n, not shortened. `angle`: of both bodies about n.
[[gnu::always_inline]] inline Vec3 turned_spring(const Vec3& spring, const Vec3& n, double angle) {
  Vec3 old = spring;
  const double size2 = spring.squaredNorm();
  if (!(size2 > 0)) return old;
  old -= n * n.dot(old);
  old += angle * n.cross(old);
  const double turned2 = old.squaredNorm();
  if (turned2 > 0) old *= std::sqrt(size2 / turned2);
  return old;
}

/// A spring of the contact goes on by `slip` (m) from `old`, where it is now, at stiffness kt up to `limit`.
[[gnu::always_inline]] inline void advance_spring(Vec3& spring, double compliance, const Vec3& old, const Vec3& slip,
                                                  double kt, double limit, BlockEnergy& e) {
  const double size2 = spring.squaredNorm(), held = 0.5 * compliance * size2;
  const double grown = kt * compliance, after = 1 / kt;
  Vec3 now = std::min(1.0, grown) * old - kt * slip;
  const double size = now.norm();
  // A spring sheds the smaller part of its stiffness or of its force; sliding takes the plastic slip times what held
  // against it, the spring at first and Coulomb's limit at last.
  e.friction += held - std::min(held * grown, 0.5 * size2 * after);
  const double first = std::min(1.0, grown) * std::sqrt(size2);
  if (size > limit) e.friction += 0.5 * (first + limit) * (size - limit) * after, now *= limit / size;
  spring = now;
  e.springs += held - 0.5 * after * now.squaredNorm() - 0.5 * (old + now).dot(slip);
}

/// Advances a touching contact to the new normal and overlap; returns the force on b. The plain form of what
/// kernel/sphere_pass.cpp does for many spheres at once.
/// Tangential form: incremental dF = -k_t dslip, rescaled by k_t/k_t,old on unloading so that no energy appears.
/// `v`: velocity of b against a at the contact point; `twist`: mean spin of both along n; `rolling`: spin of b against
/// a, whose part across n stretches the rolling spring by the effective radius (elastic-plastic spring-dashpot without
/// the dashpot: Ai et al., Powder Technology 206 (2011) 269, type C, in three dimensions). Energies are booked to `e`:
/// trapezoid of force times the half-step velocity, the discrete work of the leapfrog integrator.
template <class Law>
[[gnu::always_inline]] inline Vec3 advance_contact(const Law& law, const PairLaw& p, double effective_mass, Contact& c,
                                                   Touch& touch, const Vec3& n, double overlap, const Vec3& v,
                                                   double twist, double dt, BlockEnergy& e,
                                                   const Vec3& rolling = Vec3::Zero()) {
  const Elastic elastic = law(c.stiffness, overlap);
  const double vn = v.dot(n);
  const double normal_force = elastic.force + advance_dashpot(p, effective_mass, elastic, vn, dt, c, e);
  touch.normal = n, touch.overlap = overlap;
  if (p.friction == 0) return touch.force = normal_force * n;
  const double kt = p.shear_ratio * elastic.normal_stiffness;
  advance_spring(c.spring, c.compliance, turned_spring(c.spring, n, twist * dt), dt * (v - vn * n), kt,
                 p.friction * normal_force, e);
  if (p.rolling > 0)
    advance_spring(c.roll, c.compliance, turned_spring(c.roll, n, twist * dt),
                   dt * c.radius * (rolling - n.dot(rolling) * n), kt, p.rolling * normal_force, e);
  c.compliance = 1 / kt;
  return touch.force = normal_force * n + c.spring;
}

/// Books what a parting contact still holds, and forgets it.
inline void part_contact(Contact& c, Touch& touch, BlockEnergy& e) {
  e.friction += shear_energy(c), e.springs += shear_energy(c);
  c = {};
  touch.overlap = 0, touch.force.setZero();
}

/// Elastic energy of a contact, normal and tangential (J).
template <class Law>
inline double elastic_energy(const Law& law, const Contact& c, const Touch& touch) {
  if (c.stiffness == 0) return 0;
  if constexpr (std::is_same_v<Law, Foundation>) return touch.held + shear_energy(c);
  return law(c.stiffness, touch.overlap).energy + shear_energy(c);
}

/// Elastic part of the normal force of touching contact k (N).
inline double elastic_force(const ContactLaw& law, const Contacts& contacts, std::size_t k) {
  return std::visit([&](const auto& l) { return l(contacts.contact[k].stiffness, contacts.touch[k].overlap).force; },
                    law);
}

/// Dashpot coefficient that makes the measured restitution of a head-on impact equal `restitution`, the force being
/// cut at zero attraction. The textbook value without the cut gives 0.472 for 0.4 (Hertz).
double dashpot_for(const ContactLaw& law, double restitution);

/// Restitution that an impact shows with a dashpot coefficient (numerical integration, dimensionless).
double restitution_of(const ContactLaw& law, double dashpot);

}  // namespace grus::dem
