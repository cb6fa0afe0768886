// SPDX-License-Identifier: LGPL-3.0-or-later
// A sphere that breaks into fourteen (Ciantia et al. 2015, after Ben-Nun & Einav 2010): balls inside it, each tangent
// to it and to its neighbours, 39 pairs in all, with the poles on the line of the largest force. They hold 53.4 % of
// its volume about its centre.
#pragma once

#include <array>

#include "dem/fracture/splitter.hpp"

namespace grus::dem {

/// In a sphere of radius 1, z along the largest force.
struct Ball {
  double radius;
  Vec3 centre;
};

/// Three on the equator, three in its gaps, two at the poles, six between.
const std::array<Ball, 14>& fourteen_balls();

/// The share of the mother's volume that the balls keep.
double kept_volume();

/// Radius of the smallest, of the mother's.
double smallest_ball();

/// Spheres only.
bool can_split(const Balls& splitter, const Grains& grains, std::size_t i);

/// The turn about the line of force, which the paper leaves to the axes, is drawn by (seed, id). The contacts are new:
/// with the mother's stiffness on a ball of a twentieth of her mass, the time step would be a fifth.
Pieces pieces_of(const Balls& splitter, const Grains& grains, std::size_t i, const Wanted& wanted, std::uint64_t seed);

}  // namespace grus::dem
