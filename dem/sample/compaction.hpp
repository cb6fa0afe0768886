// SPDX-License-Identifier: LGPL-3.0-or-later
// Grains that are no spheres, closer to each other than the spheres about them could be.
#pragma once

#include "dem/sample/recipe.hpp"

namespace grus::dem {

/// Solid part of the spheres about grains beyond which these are not tried to be packed as spheres.
inline constexpr double most_in_spheres = 0.66;
/// That from which they are brought closer: loose enough to be had at once.
inline constexpr double loosest_in_spheres = 0.45;

/// The grains of a box that is larger than the recipe's, by one factor, are brought to it: without friction, breakage
/// and weight, by small steps of all places between which they push each other away. At the end next to nothing presses
/// them; `overlap`: the deepest that is left, over the smaller radius. Throws InputError where they jam before, with
/// the solid fraction that is reached; Interrupted where the watch says so.
void compact(const Model& model, const Recipe& recipe, const Vec3& larger, Grains& grains, double& overlap, Team& team,
             const Watch& watch);

}  // namespace grus::dem
