// SPDX-License-Identifier: LGPL-3.0-or-later
// How an RVE is taken through an increment, and what it answers.
#pragma once

#include <cstdint>
#include <string>

#include "dem/base/tensor.hpp"

namespace grus::dem {

/// How an increment is carried out and when it counts as equilibrium.
struct QuasiStatic {
  double strain_per_step = 1e-5;   // bound on the strain of one DEM step
  double inertial_number = 1e-3;   // target that sets the loading rate
  double pressure_floor = 0;       // Pa; the inertial number is taken at no less than this pressure
  double unbalanced_force = 1e-3;  // mean resultant / mean contact force
  double stress_change = 1e-3;     // over one window, relative to the stress or the pressure floor
  int window = 50;                 // steps between tests
  std::uint64_t max_hold = 40000;  // steps
};

struct Response {
  Mat3 stress = Mat3::Zero();                      // Cauchy, Love-Weber (Pa, tension-positive)
  Mat6 tangent = Mat6::Zero();                     // contact stiffness (Pa, Voigt, engineering shear)
  bool stable = false;                             // equilibrium reached within the tolerances
  double unbalanced_force = 0, stress_change = 0;  // at the end of the hold
  std::uint64_t steps = 0, hold_steps = 0;
  std::size_t breakages = 0;  // in this increment
  double work = 0;            // J, of the state's ledger so far; where there is no trial
  double haste = 0;  // J, so far: what of it is the price of the rate, not of the stress; where it is carried steadily
  double inertial_number = 0;  // of this advance, at the pressure at its end; where it is carried steadily
  int pieces = 1;              // that the increment was taken in
  double tangent_seconds = 0;  // wall time, of the tangent
  std::string failure;         // why it is not stable
};

}  // namespace grus::dem
