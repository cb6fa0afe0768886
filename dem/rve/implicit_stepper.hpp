// SPDX-License-Identifier: LGPL-3.0-or-later
// Steps that solve their contacts: implicit Euler, every contact's force at the end of the step at once.
#pragma once

#include "dem/rve/stepper.hpp"

namespace grus::dem {

/// Share of the contacts' forces to which forces are found: no sample comes closer to balance.
inline constexpr double least_unbalanced = 1e-3;

extern const Stepper implicit_stepper;

}  // namespace grus::dem
