// SPDX-License-Identifier: LGPL-3.0-or-later
// Columns of history.csv that a probe of grus-bvp has; their names follow "probe_<name>_".
#pragma once

#include <array>

#include "apps/run/column.hpp"

namespace grus::app {

/// What says which columns a probe has.
struct ProbeTold {
  bool place;    // all points of one, not a single point
  bool cell;     // of a single point: it has an RVE
  bool grading;  // of that
};

/// What a row is read of.
struct ProbeRow {
  std::array<double, 6> strain{}, stress{};                            // tensor components, tension-positive; Pa
  double void_ratio = 0, coordination = 0, grains = 0, breakages = 0;  // 0 where there are no grains
  std::array<double, 3> diameter{};                                    // m, at 10, 50, 90 % by mass
  double einav = 0, fines = 0;
};

using ProbeColumn = Column<ProbeRow>;
std::vector<ProbeColumn> probe_columns(const std::string& name, const ProbeTold& told);

}  // namespace grus::app
