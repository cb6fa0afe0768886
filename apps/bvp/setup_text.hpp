// SPDX-License-Identifier: LGPL-3.0-or-later
// What a macro problem is like, as it is told before it begins and by --check; and what is told of one that failed.
#pragma once

#include "apps/bvp/estimate.hpp"
#include "apps/bvp/starts.hpp"

namespace grus::app {

/// `crossing`: steps that a wave needs to cross the mesh; of explicit quasi-static runs.
std::string setup_text(const BvpScene& scene, const BvpSetup& setup, const Options& options, int ranks,
                       double crossing);

/// How long the preparation would take; `one`: what one of the starts took.
std::string preparation_text(std::size_t starts, std::size_t variants, int workers, const StartTimes& one);
/// How long the run would take.
std::string run_text(const RunEstimate& run);

/// What a run that did not get to its end says, and what may help; empty: nothing.
std::string failure_text(const BvpScene& scene, const Options& options, const BvpEnding& ending);

/// Ground that weighs more than its RVEs can bear is refused before any of them is prepared. Throws InputError.
void check_starts(const BvpScene& scene, const std::vector<Start>& starts);

}  // namespace grus::app
