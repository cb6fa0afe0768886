// SPDX-License-Identifier: LGPL-3.0-or-later
// The largest stable time step, from current contact stiffness, masses and inertia.
#pragma once

#include "dem/motion/grain_stiffness.hpp"

namespace grus::dem {

/// Share of the step beyond which dashpots drive that is taken.
inline constexpr double damped_safety = 0.8;

struct CriticalStep {
  double dt = INFINITY;      // s
  std::size_t grain = 0;     // that sets it
  double max_speed = 0;      // m/s
  bool impact = false;       // by the hardest impact that its speed allows, not by what holds it
  bool outrun = false;       // it moves by a twentieth of its least width in a step of dt
  double damped = INFINITY;  // s; beyond it dashpots drive what they should damp: they act on the velocity of half a
                             // step before. Infinite where damped_safety of it is no less than safety of dt
};

/// 2 / sqrt(largest eigenvalue bound). For grain i the bound is the largest eigenvalue of its mass-scaled 6 x 6
/// stiffness S_i = M_i^-1/2 (sum over contacts of w J^T K J) M_i^-1/2 with w = 2 for grain pairs and 1 for walls: from
/// |u_a - u_b|^2 <= 2|u_a|^2 + 2|u_b|^2, a true bound of the assembled system, exact for simple-cubic lattices.
/// Grains in flight are bounded by the stiffness of the hardest impact their speed allows.
CriticalStep critical_step(const ContactLaw& law, std::span<const PairLaw> pairs, std::size_t materials,
                           const Grains& grains, const Boundary& boundary, const Contacts& contacts,
                           const Bonds& bonds);

/// The same. `touch_only`: impacts of hulls count where nothing touches them alone. `safety`: share of dt that is
/// taken.
CriticalStep critical_step(const HeldGrains& held, bool touch_only, double safety = 1);

/// How much of the fastest motion of the grain that sets the step is turning: 0 a shift or an impact, 1 a turn; NaN
/// where its speed sets it.
double share_of_turning(const HeldGrains& held, const CriticalStep& critical);

}  // namespace grus::dem
