// SPDX-License-Identifier: LGPL-3.0-or-later
// How long a test would take: a rehearsal of it in some seconds, with grains so heavy that few steps suffice.
#pragma once

#include "apps/scene/rve_scene.hpp"
#include "dem/rve/state.hpp"
#include "dem/sample/prepare.hpp"

namespace grus::app {

struct Rehearsal {
  double steps = 0, seconds = 0;  // of the whole test; wall time
  double part = 0;                // of the test that was gone through; the rest is extrapolated
  double larger = 1;              // time steps than the test's; 1: what was gone through is the test itself
  double prepared = 0;            // s that the sample has taken before; 0: not told
};

/// Goes through the test in so many seconds of wall time, and, where that is not enough for it, with masses `larger`^2
/// times the grains' own, so that its strains and stresses come in fewer steps. What goes by steps is counted `larger`
/// times as often, its cost tried with the grains' own masses; what goes by strain (lists made anew, breakage) is
/// counted as it came.
Rehearsal rehearse(const RveScene& scene, const dem::State& begin, double budget, dem::Team& team,
                   const dem::StageWatch& watch);

/// What may be said of it, of `scale` times the grains that were rehearsed: "about 7.0 s", "8 to 20 s".
std::string time_text(const Rehearsal& found, double scale);
/// The same of steps, and what both rest on.
std::string steps_text(const Rehearsal& found);
std::string basis_text(const Rehearsal& found);

}  // namespace grus::app
