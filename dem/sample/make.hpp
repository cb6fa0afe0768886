// SPDX-License-Identifier: LGPL-3.0-or-later
// Recipe -> sample: grains, walls, periodic cell and bonds, before any force is known.
#pragma once

#include "dem/packing/voronoi_grains.hpp"
#include "dem/sample/programme.hpp"
#include "dem/sample/recipe.hpp"

namespace grus::dem {

struct Sample {
  State state;                 // at rest; `prepare` (rve/step.hpp) finds its contacts and time step
  double packing_overlap = 0;  // deepest, of grains as they were packed, over the smaller radius
  std::optional<BondedFaces> faces = {};
  std::optional<Gauge> gauge = {};  // of what presses or pulls at Voronoi cells
  std::vector<std::string> notes;   // what whoever asked for it should know

  bool bonded() const { return faces && faces->bonds > 0; }
};

/// Makes it: the same bits on any number of threads. The model tells density, bonds and seed; its pair laws are not
/// asked for. Throws InputError, with the place of what cannot be; Interrupted where the watch says so.
Sample make(const Model& model, const Recipe& recipe, Team& team, const Watch& watch = {});

/// Walls and cell of a recipe before there are grains: platens are where the box ends.
Boundary boundary_of(const Recipe& recipe);

/// A programme with what only its sample tells: what reads the load, and the times of a test between platens.
Programme fitted(Programme programme, const Sample& sample);

}  // namespace grus::dem
