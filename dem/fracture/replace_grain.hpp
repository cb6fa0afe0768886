// SPDX-License-Identifier: LGPL-3.0-or-later
// A grain gives way to its pieces, whatever splitter made them: nothing is lost that is not booked.
#pragma once

#include "dem/fracture/fracture_model.hpp"
#include "dem/state/ledger.hpp"

namespace grus::dem {

/// The first piece takes slot i, the others are appended; returns their slots. All move with the parent's rigid
/// velocity field. What they do not hold of the parent's mass, momentum, angular momentum and kinetic energy goes to
/// the fines. Generations rise by one where they are counted; contacts, bonds and strengths are the caller's.
std::vector<std::size_t> replace_grain(Grains& grains, std::size_t i, const Pieces& pieces, const FinesGrading& grading,
                                       Fines& fines);

}  // namespace grus::dem
