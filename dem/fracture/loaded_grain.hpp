// SPDX-License-Identifier: LGPL-3.0-or-later
// A grain of a state as the criteria see it; nothing is computed before they ask.
#pragma once

#include "dem/contact/laws.hpp"
#include "dem/fracture/criteria.hpp"
#include "dem/fracture/grain_stress.hpp"

namespace grus::dem {

/// Forces and torques must be up to date, contacts shown and indexed by grain.
class LoadedGrain {
public:
  LoadedGrain(const ContactLaw& law, double poissons_ratio, const Grains& grains, const Contacts& contacts,
              std::size_t i)
      : law_(law), poissons_ratio_(poissons_ratio), grains_(grains), contacts_(contacts), i_(i) {}

  Mat3 stress() const { return grain_stress(grains_, contacts_, i_); }
  double poissons_ratio() const { return poissons_ratio_; }
  double radius() const { return grains_.extent[i_].equivalent_radius; }
  Vec3 arm(Index at) const { return contact_arm(grains_, contacts_, at >> 1, at & 1); }

  /// `at`: an entry of contacts.index.entry.
  template <class F>
  void each_contact(F&& f) const {
    for (Index e = contacts_.index.first[i_]; e < contacts_.index.first[i_ + 1]; ++e) {
      const std::size_t k = contacts_.index.entry[e] >> 1;
      const Contact c = contacts_.contact[k];
      if (c.stiffness <= 0) continue;
      f(elastic_force(law_, contacts_, k), std::sqrt(c.radius * contacts_.touch[k].overlap), contacts_.index.entry[e]);
    }
  }

private:
  const ContactLaw& law_;
  double poissons_ratio_;
  const Grains& grains_;
  const Contacts& contacts_;
  std::size_t i_;
};

}  // namespace grus::dem
