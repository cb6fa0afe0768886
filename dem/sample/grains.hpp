// SPDX-License-Identifier: LGPL-3.0-or-later
// The grains of a recipe.
#pragma once

#include "dem/sample/make.hpp"

namespace grus::dem {

/// Puts them into the sample, whose periodic cell is there, with the bonds of Voronoi cells. Throws as `make` does.
void put_grains(const Model& model, const Recipe& recipe, Team& team, const Watch& watch, Sample& sample);

}  // namespace grus::dem
