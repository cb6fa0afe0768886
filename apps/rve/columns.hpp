// SPDX-License-Identifier: LGPL-3.0-or-later
// Columns of history.csv of grus-rve.
#pragma once

#include "apps/run/column.hpp"
#include "apps/rve/row.hpp"

namespace grus::app {

/// The facts that say which columns there are.
struct Told {
  const RveScene& scene;
  const dem::Sample& sample;
};

std::vector<Column<Row>> rve_columns(const Told& told);

}  // namespace grus::app
