// SPDX-License-Identifier: LGPL-3.0-or-later
// When a problem that is spread is cut anew while it runs: by what its ranks have had to do.
#pragma once

#include <cstdint>
#include <vector>

namespace grus::app {

/// Work is in one unit, any; that of a rank is the sum over its RVEs.
struct Balance {
  double fullest = 0, mean = 0;  // work of the fullest rank in each look, and of a mean one, over all looks
  double wasted = 0;             // work that the fullest rank would not have had after a new cut; since the last cut
  std::uint64_t cuts = 0;

  double imbalance() const { return mean > 0 ? fullest / mean : 1; }
};

/// What the fullest rank has to do, over the mean; 1 where nothing is to be done.
double fullness(const std::vector<double>& work);

/// Notes what the ranks have done since the last look.
void count(Balance& balance, const std::vector<double>& work);

/// Beyond it a new cut is thought of: what lies below is noise, or whole elements cannot mend it.
inline constexpr double uneven = 1.1;

/// Whether a cut pays by which the fullest rank's work falls from `now` to `anew` times the mean. It does once as much
/// has been wasted as it costs: then no course of things can make it cost more than twice what was possible. `mean`:
/// work of a mean rank since the last look; `step`: of a DEM step of all its RVEs.
bool pays(Balance& balance, double now, double anew, double mean, double step);

/// The mesh has been cut anew.
void note_cut(Balance& balance);

}  // namespace grus::app
