// SPDX-License-Identifier: LGPL-3.0-or-later
// Supports and loads of a sample of Voronoi cells: glued walls, clamps, dead loads, rollers.
#pragma once

#include "dem/sample/make.hpp"

namespace grus::dem {

/// Glues the Voronoi cells to the walls of their box.
void glue_to_walls(const Model& model, const Glue& glue, const Recipe& recipe, Sample& sample);

/// Clamps, and dead loads; the last clamp that moves reads the load.
void put_supports(const Model& model, const Supports& supports, Sample& sample);

/// Rollers that touch the Voronoi cells, and what reads their load: the fibre stress of a beam.
void put_rollers(const Rollers& rollers, const Recipe& recipe, Sample& sample);

/// A note where few Voronoi cells between plane faces are stiffer along an axis than the `modulus` of their bonds,
/// which is that of many. Cells that bonds do not make one body, and one cell alone, are no network: nothing is told
/// of them.
void note_stiffness(const Model& model, int axis, Sample& sample);

}  // namespace grus::dem
