// SPDX-License-Identifier: LGPL-3.0-or-later
// A hull under load as the criteria see it: contacts, bonds and dead loads, each where it acts.
#pragma once

#include "dem/bond/faces.hpp"
#include "dem/contact/laws.hpp"
#include "dem/state/boundary.hpp"

namespace grus::dem {

/// Fills the lists of what is bonded to each grain.
void index_bonds(std::size_t grains, const Bonds& bonds, GrainBonds& by_grain);

/// A load on a part of a grain's surface.
struct HullLoad {
  Vec3 at;               // from the mass centre (m, global)
  Vec3 force, couple;    // on the grain; the couple about `at`
  Vec3 e1, e2;           // axes of the surface, global; principal
  FaceSize face;         // no area: a point
  const FaceBond* bond;  // none: a contact or a point
  bool walled;
};

/// Across a plane in a grain, on the part beyond it, about the middle of the section (global).
struct PlaneLoad {
  double share = 0;  // of the grain's volume, the smaller part
  Vec3 middle = Vec3::Zero(), force = Vec3::Zero(), moment = Vec3::Zero();
  FlatPolygon section = {};  // about the foot of the mass centre, along `across` of the normal in the body frame
  FlatMoments moments = {};
};

/// Forces and torques must be up to date, contacts shown and indexed by grain, their spots told, bonds indexed.
class LoadedHull {
public:
  LoadedHull(const ContactLaw& law, double poissons_ratio, const Grains& grains, const Boundary& boundary,
             const Contacts& contacts, const Bonds& bonds, const GrainBonds& by_grain, std::size_t i)
      : law_(law),
        poissons_ratio_(poissons_ratio),
        grains_(grains),
        boundary_(boundary),
        contacts_(contacts),
        bonds_(bonds),
        by_grain_(by_grain),
        i_(i) {}

  /// Forces alone, at where they act, less the inertia (Pa, tension-positive): no couples, which bend a grain.
  Mat3 stress() const;
  double poissons_ratio() const { return poissons_ratio_; }
  double radius() const { return grains_.extent[i_].equivalent_radius; }
  Vec3 arm(Index at) const;

  /// `radius`: of the circle of the area of contact.
  template <class F>
  void each_contact(F&& f) const {
    for (Index e = contacts_.index.first[i_]; e < contacts_.index.first[i_ + 1]; ++e) {
      const std::size_t k = contacts_.index.entry[e] >> 1;
      const Contact c = contacts_.contact[k];
      if (c.stiffness > 0)
        f(elastic_force(law_, contacts_, k), std::sqrt(c.stiffness / (pi * c.radius)), contacts_.index.entry[e]);
    }
  }

  /// Calls f(HullLoad) for all that acts on it.
  template <class F>
  void each_load(F&& f) const {
    for (Index e = contacts_.index.first[i_]; e < contacts_.index.first[i_ + 1]; ++e)
      if (contacts_.contact.touching(contacts_.index.entry[e] >> 1)) f(of_contact(contacts_.index.entry[e]));
    if (by_grain_.first.empty()) return;
    for (Index e = by_grain_.first[i_]; e < by_grain_.first[i_ + 1]; ++e) f(of_bond(by_grain_.entry[e]));
  }

  /// Largest force of a contact, bond or dead load (N).
  double largest_force() const;

  /// Length over width; sum of force x arm over the volume (Pa).
  double slenderness() const { return 2 * grains_.motion[i_].radius / grains_.extent[i_].least_width; }
  double load_density() const;

  /// Axes of a frame fixed in the grain, in global ones.
  Mat3 axes() const { return grains_.orientation[i_].toRotationMatrix(); }

  /// The axes of the crystal, if the grain has one (Grains::crystal).
  Mat3 crystal_axes() const;

  /// Half of its width along a unit vector (global) from the mass centre on, beyond it (m).
  double reach(const Vec3& along) const;

  /// The load across the plane normal . x = offset, x from the mass centre (unit normal, global).
  PlaneLoad across_plane(const Vec3& normal, double offset) const;

  /// The force (N) that the loads lack, or have too much, beside what the grain's motion says.
  Vec3 imbalance() const;

private:
  HullLoad of_contact(Index entry) const;
  HullLoad of_bond(const GrainBonds::Entry& entry) const;
  HullView hull() const { return (*grains_.hulls)[grains_.hull[i_]]; }

  const ContactLaw& law_;
  double poissons_ratio_;
  const Grains& grains_;
  const Boundary& boundary_;
  const Contacts& contacts_;
  const Bonds& bonds_;
  const GrainBonds& by_grain_;
  std::size_t i_;
};

}  // namespace grus::dem
