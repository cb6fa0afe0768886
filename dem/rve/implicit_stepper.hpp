// SPDX-License-Identifier: LGPL-3.0-or-later
// Steps that solve their contacts: implicit Euler, every contact's force at the end of the step at once.
#pragma once

#include "dem/rve/stepper.hpp"

namespace grus::dem {

extern const Stepper implicit_stepper;

/// The same of hulls whose contacts do not give way: their forces are not unique.
extern const Stepper rigid_stepper;

inline bool steps_implicitly(const Model& m) { return m.stepper == &implicit_stepper || m.stepper == &rigid_stepper; }

}  // namespace grus::dem
