// SPDX-License-Identifier: LGPL-3.0-or-later
// The order of grains in memory: near in space, near in memory.
#pragma once

#include "dem/state/grains.hpp"

namespace grus::dem {

/// Puts the grains in the order of a space-filling (Morton) curve over their bounding box. Ids stay with their grains.
/// For new samples: indices held elsewhere (contacts, bonds) do not follow.
void sort_in_space(Grains& grains);

}  // namespace grus::dem
