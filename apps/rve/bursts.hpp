// SPDX-License-Identifier: LGPL-3.0-or-later
// Broken bonds and their bursts, told at the end of a run of bonded Voronoi cells.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// Bursts of broken bonds until a time (s), a line each: bursts.csv.
std::string bursts_text(const RveScene& scene, const dem::State& state, double until);

/// Each bond that broke until a time (s), a line each in the order of time: broken_bonds.csv.
std::string broken_bonds_text(const dem::State& state, double until);

/// Number of bursts, largest size and exponent: of summary.json.
nlohmann::json bursts_json(const RveScene& scene, const dem::State& state, double until);

}  // namespace grus::app
