// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/balance.hpp"

#include <algorithm>
#include <numeric>

namespace grus::app {
namespace {

/// DEM steps of an RVE that a cut takes as long as, for each: 97 of 427 spheres, 130 of 27 with all that is beside
/// them.
constexpr double price = 130;
constexpr double least_gain = 0.05;  // of the fullest rank's work

}  // namespace

double fullness(const std::vector<double>& work) {
  const double all = std::accumulate(work.begin(), work.end(), 0.0);
  return all > 0 ? *std::max_element(work.begin(), work.end()) * static_cast<double>(work.size()) / all : 1;
}

void count(Balance& balance, const std::vector<double>& work) {
  const double mean = std::accumulate(work.begin(), work.end(), 0.0) / static_cast<double>(work.size());
  balance.fullest += fullness(work) * mean, balance.mean += mean;
}

bool pays(Balance& balance, double now, double anew, double mean, double step) {
  balance.wasted += std::max(0.0, now - anew) * mean;
  return now - anew > least_gain * now && balance.wasted > price * step;
}

void note_cut(Balance& balance) { ++balance.cuts, balance.wasted = 0; }

}  // namespace grus::app
