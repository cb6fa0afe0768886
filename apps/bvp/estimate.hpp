// SPDX-License-Identifier: LGPL-3.0-or-later
// The time of a macro run, as --check tells it: from one RVE that is taken as the run would take it.
#pragma once

#include "apps/bvp/bvp_run.hpp"

namespace grus::app {

/// Wall time of a run's material sweeps between two bounds, and how it is made up. It leaves out what cutbacks and the
/// macro solver itself add; `rest`: what is left out, of this solver.
struct RunEstimate {
  double low = 0, high = 0;  // s; `high` 0: a run takes no less than `low`, as its steps become more
  std::string text, rest;
};

/// Rounds in which so many workers answer for all RVEs, one each: the last one may leave some idle.
double rounds_of(std::size_t rves, int workers);

/// What the run asks an RVE in a step, of which so many share a strain out between them.
dem::Task task_of(const BvpScene& scene, const dem::Vec3& strain, double steps);

/// The time of a run by `workers` threads on all ranks; the first of the prepared states is taken. Throws Unstable
/// where the RVE does not get there.
RunEstimate estimate_run(const BvpScene& scene, const BvpSetup& setup, const std::shared_ptr<const dem::Model>& model,
                         int workers);

}  // namespace grus::app
