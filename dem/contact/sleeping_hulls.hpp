// SPDX-License-Identifier: LGPL-3.0-or-later
// Pairs of hulls that a direction parts sleep until one could touch the other: nobody reads them before the ways of the
// two are as long together as the gap along that direction was. They would be found parted along it in each step in
// between, and left as they are: what sleeps decides no bit. It is of one run of steps, and no state keeps it.
#pragma once

#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/state/boundary.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

class SleepingHulls {
public:
  /// A run begins, or the list is new: all wake. `pairs` of hulls are listed, none of grains that are further apart
  /// than `reach` (m) or come to be so while the list holds.
  void wake(const Grains& grains, const Cell& cell, std::size_t pairs, double reach);
  /// Grains and cell have moved.
  void go(const Grains& grains, const Cell& cell, Team& team);

  bool asleep(std::size_t pair, Index a, Index b) const { return way_[a] + way_[b] < until_[pair]; }
  /// A direction parts the two by `gap` (m).
  void rest(std::size_t pair, Index a, Index b, double gap) { until_[pair] = way_[a] + way_[b] + (gap - blur_); }

private:
  struct Pose {
    Vec3 position;
    Quat orientation;
  };
  std::vector<double> way_;    // of each grain, against the motion of the cell: none of its points has gone further (m)
  std::vector<Pose> pose_;     // where way_ has been told
  std::vector<double> until_;  // by pair: what the ways of the two are together when it is looked at again (m)
  Mat3 cell_ = Mat3::Zero();
  double reach_ = 0, blur_ = 0;  // m; blur: of a gap and of the ways until it is used up, more than all round-off
};

}  // namespace grus::dem
