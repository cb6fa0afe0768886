// SPDX-License-Identifier: LGPL-3.0-or-later
// Steps that solve their contacts: implicit Euler, every contact's force at the end of the step at once.
#pragma once

#include "dem/motion/cone_solver.hpp"
#include "dem/rve/stepper.hpp"

namespace grus::dem {

/// Share of the contacts' forces to which forces are found: no sample comes closer to balance.
inline constexpr double least_unbalanced = 1e-3;

/// How well the forces of a step of `dt` (s) are to be found. A step in which forces change little must find them the
/// better: what is off is given and taken in each step, and springs at their limit give a part of it to friction. One
/// that is as short as it gets (state.watch off) has more iterations for it.
ConeSettings accuracy_of(const State& state, double dt);

extern const Stepper implicit_stepper;

}  // namespace grus::dem
