// SPDX-License-Identifier: LGPL-3.0-or-later
// Steps of hulls that do not give way, as engines for rigid bodies take them: blows without rebound, Coulomb's
// friction, contacts of several points. Their forces are not unique.
#pragma once

#include "dem/rve/stepper.hpp"

namespace grus::dem {

extern const Stepper rigid_stepper;

}  // namespace grus::dem
