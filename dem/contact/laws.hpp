// SPDX-License-Identifier: LGPL-3.0-or-later
// Contact laws as values with a call operator; each sees one contact and nothing else. A law answers for itself: all
// that other rooms do with a contact asks here, and none asks which law it is. What a law must have is in law.hpp and
// in the three below; a new one is its file, a name in each of the three lists here, and its row in the kernels.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <variant>

#include "dem/contact/foundation.hpp"
#include "dem/contact/hertz_mindlin.hpp"
#include "dem/contact/jkr.hpp"
#include "dem/contact/linear_spring.hpp"
#include "dem/contact/springs.hpp"

namespace grus::dem {

template <class... Laws>
struct LawList {
  using Any = std::variant<Laws...>;
  using Of = std::variant<typename Laws::Of...>;
  using Pair = std::variant<typename Laws::Pair...>;

  /// Calls f on the law whose constants these are.
  static void of(const Of& constants, auto&& f) {
    ((std::holds_alternative<typename Laws::Of>(constants) ? f(Laws{}) : void()), ...);
  }
};
using AllLaws = LawList<HertzMindlin, LinearSpring, Foundation, Jkr>;

using ContactLaw = AllLaws::Any;
using LawConstants = AllLaws::Of;  // of a material

/// Constants of a pair of materials (or grain and wall).
struct PairLaw {
  double shear_ratio = 0;  // shear stiffness / grip; Hertz-Mindlin: 4 G*/E*
  // Of each spring its largest force over the normal force; of couples 0 where nothing slides.
  std::array<double, spring_rows> friction{};
  double dashpot = 0;  // coefficient c in c sqrt(m* grip)
  AllLaws::Pair own;   // the law's
};

/// The constants of `Law`: of a pair or a material; as good as none where they are of another law.
template <class Law>
typename Law::Pair own(const PairLaw& p) {
  const auto* found = std::get_if<typename Law::Pair>(&p.own);
  return found ? *found : typename Law::Pair{};
}
template <class Law>
Partner<typename Law::Of> partner(const Solid& solid, const LawConstants& of) {
  const auto* found = std::get_if<typename Law::Of>(&of);
  return {solid, found ? *found : typename Law::Of{}};
}

/// Force of the dashpot along n (N), at the approach speed -vn; no attraction beyond what parts the contact.
[[gnu::always_inline]] inline double advance_dashpot(const PairLaw& p, double effective_mass, const Elastic& elastic,
                                                     double vn, double dt, Contact& c, BlockEnergy& e) {
  if (!(p.dashpot > 0)) return 0;
  const double viscous =
      std::max(-p.dashpot * std::sqrt(effective_mass * elastic.grip) * vn, -(elastic.force + elastic.pull_off));
  e.viscous -= 0.5 * (c.viscous + viscous) * vn * dt;
  c.viscous = viscous;
  return viscous;
}

/// Advances a touching contact to the new normal and overlap; returns the force on b. The plain form of what
/// kernel/sphere_pass.cpp does for many spheres at once.
/// Tangential form: incremental dF = -k_t dslip, rescaled by k_t/k_t,old on unloading so that no energy appears.
/// `v`: velocity of b against a at the contact point; `twist`: mean spin of both along n; `turn`: spin of b against a,
/// which stretches the couples' springs by the effective radius (elastic-plastic spring-dashpot without the dashpot: Ai
/// et al., Powder Technology 206 (2011) 269, type C, in three dimensions). Energies are booked to `e`: trapezoid of
/// force times the half-step velocity, the discrete work of the leapfrog integrator.
template <class Law>
[[gnu::always_inline]] inline Vec3 advance_contact(const Law& law, const PairLaw& p, double effective_mass, Contact& c,
                                                   Touch& touch, const Vec3& n, double overlap, const Vec3& v,
                                                   double twist, double dt, BlockEnergy& e,
                                                   const Vec3& turn = Vec3::Zero()) {
  const Elastic elastic = law(c, overlap);
  const double vn = v.dot(n);
  const double normal_force = elastic.force + advance_dashpot(p, effective_mass, elastic, vn, dt, c, e);
  touch.normal = n, touch.overlap = overlap;
  if (p.friction[slide_spring] == 0) return touch.force = normal_force * n;
  const double kt = p.shear_ratio * elastic.grip, borne = elastic.bears(normal_force);
  const auto advance = [&](SpringRow row, const Vec3& slip) {
    advance_spring(c.spring[row], c.compliance, turned_spring(row, c.spring[row], n, twist * dt), slip, kt,
                   p.friction[row] * borne, e);
  };
  advance(slide_spring, dt * (v - vn * n));
  for (const SpringRow row : couple_springs)
    if (p.friction[row] > 0) advance(row, dt * c.radius * own_part(row, turn, n));
  c.compliance = 1 / kt;
  return touch.force = normal_force * n + c.spring[slide_spring];
}

/// A pair begins to touch. `ellipse`: of contacts that are no circles, shape/common_normal.hpp.
template <class Law>
void begin_contact(const PairLaw& p, double effective_radius, double ellipse, Contact& c, BlockEnergy& e) {
  Law::begin(own<Law>(p), effective_radius, ellipse, c);
  if constexpr (Law::attracts) e.adhesion += Law::snap_on(c);
}

/// What a parting contact takes beside what its springs hold (J).
template <class Law>
void part_from(const Contact& c, BlockEnergy& e) {
  if constexpr (Law::attracts) e.adhesion += Law::snap_off(c);
}

/// Books what a parting contact still holds, and forgets it.
inline void part_contact(Contact& c, Touch& touch, BlockEnergy& e) {
  e.friction += shear_energy(c), e.springs += shear_energy(c);
  c = {};
  touch.overlap = 0, touch.force.setZero();
}

/// Elastic energy of a contact, normal and tangential (J); with attraction that of the surfaces too, 0 where they part.
template <class Law>
inline double elastic_energy(const Law& law, const Contact& c, const Touch& touch) {
  if (c.stiffness == 0) return 0;
  if constexpr (Law::of_hulls) return touch.held + shear_energy(c);
  return law(c, touch.overlap).energy + shear_energy(c);
}

/// Response of touching contact k.
inline Elastic elastic_response(const ContactLaw& law, const Contacts& contacts, std::size_t k) {
  return std::visit([&](const auto& l) { return l(contacts.contact[k], contacts.touch[k].overlap); }, law);
}

/// Elastic part of the normal force of touching contact k (N).
inline double elastic_force(const ContactLaw& law, const Contacts& contacts, std::size_t k) {
  return elastic_response(law, contacts, k).force;
}

/// Fills p.own and p.shear_ratio from two materials.
void mix(const ContactLaw& law, const Solid& a, const LawConstants& of_a, const Solid& b, const LawConstants& of_b,
         PairLaw& p);

/// Normal force at an overlap (N); infinite of hulls, of which overlap and radius do not tell it.
double force_at(const ContactLaw& law, const PairLaw& p, double effective_radius, double overlap);

/// Largest separation at which a contact may still hold (m); 0 without attraction.
double reach_of(const ContactLaw& law, std::span<const PairLaw> pairs, double largest_radius);

/// Largest stiffness of the hardest impact (N/m).
double hardest_impact(const ContactLaw& law, const PairLaw& p, const Impact& impact);

/// Stiffness of a contact between two balls of a material (N/m), as a scale.
double stiffness_between(const ContactLaw& law, const Solid& solid, const LawConstants& of, double radius);

/// Elastic energy of a grain at a strain of 1 (J), as a scale.
double energy_of_strain(const ContactLaw& law, const Solid& solid, const LawConstants& of, double volume);

/// The constants with which grains that are larger by `factor` behave alike.
void scale(const ContactLaw& law, LawConstants& of, double factor);

/// Of a law that attracts; none of others. `part`: of the radius of two equal spheres (m), their overlap.
std::optional<Attraction> attraction(const Solid& solid, const LawConstants& of, double radius, double part);

/// Whether contacts attract, are those of hulls, stiffen as they are pressed.
bool attracts(const ContactLaw& law);
bool of_hulls(const ContactLaw& law);
bool stiffens(const ContactLaw& law);

/// E* of a pair (Pa); 0 where the law does not ask for it.
double reduced_modulus(const PairLaw& p);

/// Dashpot coefficient that makes the measured restitution of a head-on impact equal `restitution`, the force being
/// cut at zero attraction, of surfaces that do not attract. The textbook value without the cut gives 0.472 for 0.4
/// (Hertz).
double dashpot_for(const ContactLaw& law, double restitution);

/// Restitution that an impact shows with a dashpot coefficient (numerical integration, dimensionless).
double restitution_of(const ContactLaw& law, double dashpot);

}  // namespace grus::dem
