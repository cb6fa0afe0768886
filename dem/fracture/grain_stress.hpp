// SPDX-License-Identifier: LGPL-3.0-or-later
// Average Cauchy stress of one grain with the dynamic term (Zhang et al. 2015, eqs 3-13).
#pragma once

#include "dem/state/contacts.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// Lever of contact k about its grain a or b (midpoint of the two support points, from the centre of mass).
Vec3 contact_arm(const Grains& grains, const Contacts& contacts, std::size_t k, bool is_b);

/// Integral of rho a (x) x, a the acceleration against that of the centre of mass: with rigid motion (alpha cross +
/// omega cross omega cross) times the second moments of mass (J). Uses grains.torque.
Mat3 motion_virial(const Grains& grains, std::size_t i);

/// sigma = (1/V) sym[ sum f (x) x - integral of rho a (x) x ], tension-positive (Pa), x from the centre of mass: with
/// rigid motion the inertia term is (alpha cross + omega cross omega cross) times the second moments of mass. Uses
/// grains.torque, the resultant of the present contact forces. Gravity drops out about the centre of mass.
Mat3 grain_stress(const Grains& grains, const Contacts& contacts, std::size_t i);

}  // namespace grus::dem
