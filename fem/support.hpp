// SPDX-License-Identifier: LGPL-3.0-or-later
// Whether prescribed displacements hold a body: what increments of Newton need, and steps of central differences not.
#pragma once

#include <string>

#include "fem/problem.hpp"

namespace grus::fem {

/// The rigid motions that no prescribed displacement stops, such as "moving along x and turning about z"; empty: none.
/// On one rank of each part of the mesh that shares no node with the rest, else of the whole. Collective.
std::string loose_motions(Problem& problem);

}  // namespace grus::fem
