// SPDX-License-Identifier: LGPL-3.0-or-later
// What the run of a macro problem carries from response to response.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "apps/bvp/bvp_run.hpp"
#include "apps/run/signals.hpp"

namespace grus::app {

struct BvpRun::Course {
  const Clock& clock;
  const AcrossRanks& across;
  double ready;  // s that the preparation has taken
  Progress progress;
  double time, saved;  // of the problem; wall time of the last checkpoint (s)
  std::uint64_t sweeps = 0;
  TimeLimit limit;
  bool asked = false;             // to stop, on any rank of a problem that is spread
  std::optional<int> heard = {};  // what any rank of it has wished in this step, where that is known
  Stop stop = Stop::none;
  bool told = false;               // that the increment is ended before the run stops
  bool owed = false, cut = false;  // after this step: a checkpoint, a new cut of the mesh
  bool apart = false;              // while the mesh is cut anew there is no problem
  bool over = false, complete = false, broken = false;
  double end = 0;
  std::string failure = {}, gains = {};  // gains: energy that the regularisation has made

  /// Explicit runs stop between two rows, too, where a checkpoint is due or asked for.
  bool due(double interval) {
    if (!across.spread()) return wishes(interval) != 0;
    const int any = heard ? *heard : across.any(wishes(interval));
    heard.reset();
    over = (any & 1) != 0, asked = (any & 2) != 0;
    return any != 0;
  }
  int wishes(double interval) {
    over = limit.over() || over;
    const bool wanted = checkpoint_asked() || clock.wall() - saved > interval;
    return (over ? 1 : 0) | (interruption_asked() ? 2 : 0) | (wanted ? 4 : 0);
  }
  Stop why() const {
    if (!across.spread()) return stop_of(over);
    return asked ? Stop::asked : over ? Stop::time : Stop::none;
  }
};

}  // namespace grus::app
