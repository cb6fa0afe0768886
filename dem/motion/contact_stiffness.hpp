// SPDX-License-Identifier: LGPL-3.0-or-later
// How stiffly the contacts of a state resist, as the critical step asks for it.
#pragma once

#include "dem/base/parallel.hpp"
#include "dem/motion/grain_stiffness.hpp"

namespace grus::dem {

/// Of every contact. `ahead` (s): hulls that may meet within that time hold each other already. Found by `team`, the
/// same for any number of threads.
Stiffnesses stiffnesses(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& g,
                        const Boundary& boundary, const Contacts& contacts, double ahead, Team& team);

}  // namespace grus::dem
