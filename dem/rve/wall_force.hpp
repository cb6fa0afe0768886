// SPDX-License-Identifier: LGPL-3.0-or-later
#pragma once

#include "dem/rve/state.hpp"

namespace grus::dem {

/// The force of contacts and bonds on a wall, and on the grains that move with it (N).
Vec3 wall_force(const State& state, std::size_t wall);

}  // namespace grus::dem
