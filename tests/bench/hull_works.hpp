// SPDX-License-Identifier: LGPL-3.0-or-later
// Samples of convex hulls that are timed.
#pragma once

#include <functional>

#include "tests/bench/works.hpp"

namespace grus::bench {

/// The sample of apps/scenes/angular_rve.toml at 100 kPa, ready to be compressed along z.
Sample angular();
/// The same grains of 10 GPa, cleft until there are three times as many; none cleaves any more.
Sample broken();
/// Voronoi cells that fill a periodic cell, unbonded, pressed by a hundredth of strain.
Sample cells();

/// The rows of hulls, told one by one: of each of those samples the best of three runs of `steps`, its contacts, and
/// its contact pass.
void time_hulls(std::uint64_t steps, const std::function<void(Row)>& tell);

}  // namespace grus::bench
