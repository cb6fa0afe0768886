// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/grain_stress.hpp"

#include "dem/state/shape_kinds.hpp"

namespace grus::dem {

Vec3 contact_arm(const Grains& g, const Contacts& contacts, std::size_t k, bool is_b) {
  const Touch& t = contacts.touch[k];
  const Vec3 outward = is_b ? Vec3(-t.normal) : t.normal;
  return surface_arm(g, is_b ? contacts.pair[k].b : contacts.pair[k].a, outward) - 0.5 * t.overlap * outward;
}

Mat3 motion_virial(const Grains& g, std::size_t i) {
  const Mat3 inertia = inertia_tensor(g, i);
  const Mat3 moment = 0.5 * inertia.trace() * Mat3::Identity() - inertia;  // integral of rho x x^T
  const Vec3 spin = spin_of(g, i);
  const Vec3 alpha = inertia.inverse() * (g.torque[i] - spin.cross(g.angular_momentum[i]));
  return (cross_matrix(alpha) + cross_matrix(spin) * cross_matrix(spin)) * moment;
}

Mat3 grain_stress(const Grains& g, const Contacts& contacts, std::size_t i) {
  Mat3 sum = Mat3::Zero();
  for (Index e = contacts.index.first[i]; e < contacts.index.first[i + 1]; ++e) {
    const std::size_t k = contacts.index.entry[e] >> 1;
    if (!contacts.contact.touching(k)) continue;
    const bool is_b = contacts.index.entry[e] & 1;
    // The undeformed surface point goes with the undeformed volume: F = 2 pi R^2 strength / 3 holds at any overlap.
    const Vec3 arm = surface_arm(g, i, is_b ? Vec3(-contacts.touch[k].normal) : contacts.touch[k].normal);
    sum += (is_b ? 1.0 : -1.0) * contacts.touch[k].force * arm.transpose();
  }
  sum -= motion_virial(g, i);
  return 0.5 * (sum + sum.transpose()) / g.extent[i].volume;
}

}  // namespace grus::dem
