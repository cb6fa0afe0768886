// SPDX-License-Identifier: LGPL-3.0-or-later
// What a run of grus-rve knows of its own error; "errors" of summary.json.
#pragma once

#include <nlohmann/json.hpp>

#include "dem/rve/measure.hpp"

namespace grus::app {

/// Largest and last value of one estimate over the rows of history.csv.
struct Estimate {
  double worst = 0, last = 0;

  void add(double value) {
    last = value;
    if (!(value <= worst)) worst = value;
  }
};

struct ErrorEstimates {
  Estimate energy, unbalanced, overlap;  // |energy_error|; unbalanced force; overlap / radius of the deepest contact
  Estimate wall_minus_cell;   // of a box's pressure: |wall force / area - Love-Weber| / largest wall pressure so far
  Estimate pressure_scatter;  // standard error of the mean pressure, relative: see dem::Survey

  double largest_wall = 0;  // Pa

  void add(const dem::State& state, const dem::Survey& m);
  nlohmann::json json(const dem::State& state) const;

  template <class A, class E>
  static void archive(A& a, E& e) {
    for (auto* v : {&e.energy, &e.unbalanced, &e.overlap, &e.wall_minus_cell, &e.pressure_scatter}) a.plain(*v);
    a.plain(e.largest_wall);
  }
};

}  // namespace grus::app
