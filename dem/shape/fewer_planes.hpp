// SPDX-License-Identifier: LGPL-3.0-or-later
// Bodies of more corners or faces than a hull has room for lose planes, those that change them least.
#pragma once

#include "dem/shape/polyhedron.hpp"

namespace grus::dem {

/// Whether a hull has room for it (hull_store.hpp).
bool fits(const Polyhedron& body);

/// Takes planes away, each time the one whose loss adds the least volume, until the body fits; it then shrinks to the
/// volume that it had, about its mass centre, which stays where it was. Faces of tag `kept` and above are not taken:
/// other bodies lie beyond them. Tags are 0 and above. Returns how many were taken; a body that cannot be made to fit
/// is left as it is then.
int drop_planes(Polyhedron& body, std::int64_t kept);

}  // namespace grus::dem
