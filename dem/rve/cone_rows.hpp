// SPDX-License-Identifier: LGPL-3.0-or-later
// The contacts of a state as rows of the cone solver: implicit Euler of the contact laws, linearised at the present
// positions. What the solver finds is what the laws will say at the end of the step, to the square of the step.
#pragma once

#include "dem/motion/cone_solver.hpp"
#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

struct ConeSystem {
  std::vector<ConeBody> body;        // by grain
  std::vector<ConeContact> contact;  // those that touch
  std::vector<ConeRows> held;        // N, N m: what each row holds at the start of the step
  std::vector<ConeRows> moved;       // m/s, rad/s: velocity of each row as the step begins, walls' and cell's included
  std::vector<double> stiffness;     // N/m, of the press, without its dashpot
  std::vector<double> energy;        // J, of the press
  std::vector<Index> pair;           // of each contact
};

/// `dt` (s): the step to come. Contacts must have been shown.
void fill(const Model& model, const State& state, double dt, Team& team, ConeSystem& system);

}  // namespace grus::dem
