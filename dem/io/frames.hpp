// SPDX-License-Identifier: LGPL-3.0-or-later
// Grain surfaces with per-grain fields, as a VTKHDF frame.
#pragma once

#include <string>

#include "dem/rve/state.hpp"

namespace grus::dem {

/// One frame: triangulated surfaces; cell fields id, radius, speed, generation, material, coordination and mean
/// pressure of the grain (Pa, compression-positive).
void write_grains(const std::string& path, const State& state);

}  // namespace grus::dem
