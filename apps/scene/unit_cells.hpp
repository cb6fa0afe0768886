// SPDX-License-Identifier: LGPL-3.0-or-later
// The unit cells of Gauss points: packings that differ by their seeds, and how they respond.
#pragma once

#include "apps/scene/rve_scene.hpp"
#include "dem/rves/driver_options.hpp"

namespace grus::app {

/// Unit cells of one file, `variants` of them: the v-th has packing.seed + v.
std::vector<RveScene> read_unit_cells(const std::string& file, std::vector<std::string> overrides, int variants);

/// Quasi-static keys, `tangent`, `perturbation`, `perturbation_central`, `exact_sharing` and the table `adaptivity` of
/// a table (of [rve], or what a program gives).
dem::RveOptions read_rve_options(Table& table);

/// Below the pressure it was prepared at, an RVE is a loose heap: tolerances are then against half that pressure.
void default_floor(dem::ResponseOptions& response, const RveScene& cell);

/// Options of responses, and of what may be left out, that a program gives: lines KEY = VALUE, as in [rve]. Throws
/// InputError that begins with `place`.
dem::RveOptions options_of_text(const std::string& text, const std::string& place, const RveScene& cell);

/// A number that scenes share whose RVEs can take each other's states: they differ in packing.seed at most.
std::uint64_t kin_of(const RveScene& cell);

}  // namespace grus::app
