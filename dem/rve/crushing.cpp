// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/crushing.hpp"

#include "dem/contact/deepest_contact.hpp"

namespace grus::dem {

double whole_solid(const Model& model, const State& s) {
  double sum = s.ledger.fines.volume;
  for (std::size_t i = 0; i < s.grains.size(); ++i)
    sum += solid_mass(s.grains, i) / model.materials[s.grains.material[i]].density;
  return sum;
}

double lateral_ratio(const Vec3& stresses, int axis) {
  const double axial = stresses[axis];
  return axial != 0 ? 0.5 * (stresses.sum() - axial) / axial : NAN;
}

double share_deeper(const State& s, double part) {
  const Contacts& c = s.contacts;
  std::size_t touching = 0, deep = 0;
  for (std::size_t k = 0; k < c.size(); ++k) {
    if (!c.contact.touching(k)) continue;
    const double radius = smaller_radius(s.grains, c.pair[k], k >= c.begin[first_wall]);
    ++touching;
    deep += c.touch[k].overlap > part * radius;
  }
  return touching > 0 ? static_cast<double>(deep) / static_cast<double>(touching) : 0;
}

}  // namespace grus::dem
