// SPDX-License-Identifier: LGPL-3.0-or-later
// Which work of RVEs may be left out, and what that has saved and cost.
#pragma once

#include <algorithm>

#include "dem/rves/host.hpp"

namespace grus::dem {

/// Work that may be left out. With everything off every point advances an RVE of its own at every response.
struct RveOptions {
  ResponseOptions response;
  Pace pace = Pace::relaxed;
  bool exact_sharing = true;  // points of one history have one RVE; the same bits as without
  double share = 0;           // similar sharing: largest difference of deformation gradients, over the history; 0: off
  double error = 0;           // deferral: largest predicted stress change relative to the stress, since the last commit
                              // or since this increment's last DEM answer; 0: off
};

/// How well a device keeps to its tolerance: errors measured whenever the truth comes out, relative to the stress.
struct MeasuredError {
  std::uint64_t count = 0;
  double worst = 0, sum = 0;
  void add(double error) {
    ++count;
    sum += error;
    worst = std::max(worst, error);
  }
  double mean() const { return count > 0 ? sum / static_cast<double>(count) : 0; }
};

/// Figures of the last commit and of everything since the start.
struct SweepReport {
  std::uint64_t asked = 0, advanced = 0, deferred = 0, elastic = 0, similar = 0, replayed = 0,
                retried = 0;  // answers; of them DEM runs, others
  std::uint64_t dem_steps = 0;
  std::uint64_t distinct = 0;               // RVEs now
  MeasuredError deferral, sharing, linear;  // prediction against what the RVE then did; at replays; of elastic points
  double least_trust = 1;                   // lowest share of the deferral tolerance that a slot was left with
  double correction = 0;                    // largest first-order correction of a similar point, relative to its stress
  double worst_unbalanced = 0, worst_stress_change = 0;  // of the last commit
  double inertial_number = 0;                            // mean of the steady cells in the last response
  std::uint64_t given_up = 0;                            // RVEs that answer with what is left of their stiffness
};

}  // namespace grus::dem
