// SPDX-License-Identifier: LGPL-3.0-or-later
// What all steps have in common that solve their contacts, whether these give way or not.
#pragma once

#include "dem/motion/cone_solver.hpp"
#include "dem/motion/integrate.hpp"
#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// All grains as bodies of the solver.
void fill_bodies(const Grains& grains, Team& team, std::vector<ConeBody>& body);

/// Motion between solutions: gravity is in the impulses.
MotionSettings solved_motion(const Model& model, const State& state);

/// The grains' changes of velocity in a step, and `fall`, what gravity adds to each (m/s), as twice the mean force and
/// torque on each grain in the step. Adds 1/2 dv M dv to what the scheme has `lost`, and gravity's to the `work` (J).
void take_changes(const Grains& grains, const std::vector<ConeSolver::Change>& change, const Vec3& fall, double dt,
                  std::vector<Vec3>& force, std::vector<Vec3>& torque, double& lost, double& work);

}  // namespace grus::dem
