// SPDX-License-Identifier: LGPL-3.0-or-later
// Tangent of an RVE by perturbation: what the sample does, sliding and breakage included, instead of what it would do
// elastically.
#pragma once

#include "dem/rve/rve.hpp"

namespace grus::dem {

/// d Cauchy stress / d strain (Pa, Voigt, engineering shear) at an equilibrium state: each column from a scratch copy
/// that is deformed by `strain` and held; central differences cost twelve copies, one-sided six. Columns whose copy
/// does not come to rest are those of the contact stiffness. The state is not touched; `steps` grows by the copies' DEM
/// steps. `told`: as in `deform`; with one thread only.
Mat6 perturbation_tangent(const Model& model, const QuasiStatic& options, const State& state, double strain,
                          bool central, std::uint64_t& steps, Team& team, const std::function<void()>& told = {});

/// Broyden's update: the least change of `tangent` that maps the strain step to the stress step; steps below 1e-12 are
/// ignored.
void broyden_update(const Vec6& strain_step, const Vec6& stress_step, Mat6& tangent);

}  // namespace grus::dem
