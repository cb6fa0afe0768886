// SPDX-License-Identifier: LGPL-3.0-or-later
// Cohesive springs across fresh fracture planes.
#pragma once

#include <vector>

#include "dem/base/tensor.hpp"

namespace grus::dem {

/// One spring between two fragments. Opening w = (point on b - point on a) + preload, force on b = -secant stiffness *
/// w.
struct CohesiveSpring {
  Index a, b;
  Vec3 at_a, at_b;            // from each centre of mass, in each geometry frame (m)
  Vec3 normal_a;              // plane normal from a to b, geometry frame of a
  Vec3 preload;               // geometry frame of a (m): the opening that carries the initial force
  double peak;                // largest force (N)
  double onset, rupture;      // openings (m) of peak and of zero force
  double reached;             // largest opening so far, at least onset
  Vec3 force = Vec3::Zero();  // on b, global (N)
};

/// Springs are kept sorted by birth; a broken one is removed.
using Bonds = std::vector<CohesiveSpring>;

}  // namespace grus::dem
