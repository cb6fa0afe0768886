// SPDX-License-Identifier: LGPL-3.0-or-later
// The walls of a recipe: of its bounds, its own, and platens that touch the grains.
#pragma once

#include "dem/sample/make.hpp"

namespace grus::dem {

/// The recipe's own walls go to the sample, whose grains are there. Throws InputError where a wall is where another is,
/// leaves no place, or has a grain behind it; of random packings grains are not asked.
void put_own_walls(const Recipe& recipe, Sample& sample);

/// Those of the bounds, around the box.
void put_bounds(const Recipe& recipe, Boundary& boundary);

/// Gives rough walls the grains that move with them. Throws InputError where a wall finds none, or none is left free.
void fix_grains(const Recipe& recipe, Sample& sample);

/// Two plates from `low` to `high` along their axis; the upper one moves.
void put_platens(const Platens& platens, double low, double high, Boundary& boundary);

/// The same, touching the grains; what reads the load of Voronoi cells between them.
void put_platens(const Platens& platens, const Recipe& recipe, Sample& sample);

}  // namespace grus::dem
