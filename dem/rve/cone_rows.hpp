// SPDX-License-Identifier: LGPL-3.0-or-later
// The contacts of a state as rows of the cone solver: implicit Euler of the contact laws, linearised at the present
// positions. What the solver finds is what the laws will say at the end of the step, to the square of the step.
#pragma once

#include "dem/motion/cone_solver.hpp"
#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// A contact at the start of a step.
struct HeldContact {
  ConeRows held{}, moved{};    // N, N m: what its rows hold; m/s, rad/s: how they move, the boundary's motion included
  double energy = 0;           // J, of the press
  double viscous = 0;          // N, of the press: its dashpot
  Vec3 driven = Vec3::Zero();  // m/s: how the boundary moves b, or its image
  Index pair = 0;
};

struct ConeSystem {
  std::vector<ConeBody> body;        // by grain
  std::vector<ConeContact> contact;  // those that press
  std::vector<HeldContact> held;     // the same
  std::vector<std::uint8_t> presses;
};

/// `dt` (s): the step to come. `rigid`: hulls do not give way. Contacts must have been shown.
void fill(const Model& model, const State& state, double dt, bool rigid, Team& team, ConeSystem& system);

}  // namespace grus::dem
