// SPDX-License-Identifier: LGPL-3.0-or-later
// The stiffness of RVEs where they start from, for what is answered elastically beside them.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::coupling {

/// Of each point, which starts from `states[start[point]]`: the relaxed elastic stiffness of its network (Pa, 36 row by
/// row, Voigt xx yy zz yz xz xy, engineering shear), its symmetric part. Throws dem::InputError where a state has none.
std::vector<std::array<double, 36>> start_stiffness(const dem::Model& model, const std::vector<dem::State>& states,
                                                    std::span<const std::size_t> start);

}  // namespace grus::coupling
