// SPDX-License-Identifier: LGPL-3.0-or-later
// The states that the RVEs of a macro problem start from: made by all ranks, kept in a file while that takes long.
#pragma once

#include <nlohmann/json.hpp>

#include "apps/bvp/points.hpp"

namespace grus::app {

/// preparation.h5: what has been prepared so far. A run that stops meanwhile, or later, has not to do it again.
struct StartsFile {
  std::string path;
  double interval = 300;                    // s of wall time between writes
  bool resume = false;                      // read what is there first
  std::function<void()> before_it = [] {};  // the first write
};

/// The time that preparation has taken on this rank, all in all (s of one thread).
struct StartTimes {
  double packing = 0, stress = 0;  // to pack and compress; from there to the stresses
};

/// On rank 0 the states, and of each what its preparation has made of its packing (tell_preparation); elsewhere none.
struct Starts {
  std::vector<dem::State> states;
  std::vector<nlohmann::json> told;
  StartTimes times;
};

/// All starts of a packing go on from one sample, packed and compressed once; the same bits as each for itself.
/// Collective over MPI_COMM_WORLD. Throws, on all ranks or on rank 0, what the first one that cannot be made throws:
/// InputError (also for a file of another scene), Unstable, Interrupted where a rank's watch says so.
Starts prepare_starts(const BvpScene& scene, const std::vector<Start>& starts, int threads, const dem::Watch& watch,
                      const StartsFile& file = {});

}  // namespace grus::app
