// SPDX-License-Identifier: LGPL-3.0-or-later
// Whether an element can be integrated over at all.
#pragma once

#include <span>
#include <string>

#include "fem/mesh.hpp"

namespace grus::fem {

/// The fault of an element, nodes in Gmsh's order; empty if nothing. Flat: its volume at some corner is below
/// 1e-10 of the cube of its longest edge there. Folded: the volumes at its corners differ in sign.
std::string cell_fault(CellKind kind, std::span<const Point> nodes);

}  // namespace grus::fem
