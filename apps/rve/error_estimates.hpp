// SPDX-License-Identifier: LGPL-3.0-or-later
// A run of grus-rve knows this of its own error: "errors" of summary.json.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "dem/rve/servo.hpp"

namespace grus::app {

/// Largest and last value of one estimate over the rows of history.csv.
struct Estimate {
  double worst = 0, last = 0;

  void add(double value) {
    last = value;
    if (!(value <= worst)) worst = value;
  }
};

/// Energy that devices of no rock took until the largest stress so far, of either sign, and how far the test was from
/// rest (J).
struct BeforePeak {
  double local_damping = 0, bond_damping = 0;  // until then
  double kinetic = 0;                          // the largest of the rows until then
  double scale = 0;                            // what was exchanged until then: see dem::energy_scale
  double most_kinetic = 0;                     // of all rows so far
  double largest = 0;                          // of the stress, of either sign (Pa)

  /// A row: the stress that the test tells (Pa), the kinetic energy and all that is stored (J), now.
  void add(const dem::Ledger& ledger, double stress, double kinetic_now, double stored) {
    most_kinetic = std::max(most_kinetic, kinetic_now);
    if (std::abs(stress) < largest) return;
    largest = std::abs(stress);
    local_damping = ledger.local_damping, bond_damping = ledger.bond_damping, kinetic = most_kinetic;
    scale = dem::energy_scale(ledger, stored);
  }
  /// The share of what was exchanged (0 before any row).
  double share(double joule) const { return scale > 0 ? joule / scale : 0; }
  double devices() const { return share(local_damping + bond_damping); }
};

/// Devices that take more than this of the work before the peak are told of: the peak is partly theirs.
inline constexpr double most_devices = 0.05;

/// Splits that put in more than this of the work are told of.
inline constexpr double most_split = 0.05;

/// A stress that is off by more than this, on average over the rows, is told of.
inline constexpr double most_stress_error = 0.01;

struct ErrorEstimates {
  Estimate energy, unbalanced, overlap;  // |energy_error|; unbalanced force; overlap / radius of the deepest contact
  Estimate wall_minus_cell;   // of a box's pressure: |wall force / area - Love-Weber| / largest wall pressure so far
  Estimate pressure_scatter;  // standard error of the mean pressure, relative: see dem::Survey

  Estimate stress;        // of axes that seek a stress: see dem::stress_error
  double stress_sum = 0;  // of it
  std::uint64_t stress_rows = 0;
  bool holds = false;  // it is the lateral stress of a test that drives another axis

  double largest_wall = 0;  // Pa

  BeforePeak before_peak;

  void add(const dem::State& state, const dem::Loading& loading, const dem::Survey& m);
  /// Over the rows (0 without any).
  double mean_stress_error() const { return stress_rows > 0 ? stress_sum / static_cast<double>(stress_rows) : 0; }
  /// Where the stress is off: what to change. `solved`: steps solve their contacts; `presses`: walls seek the stress.
  const char* advice(bool solved, bool presses) const;
  nlohmann::json json(const dem::State& state) const;
};

}  // namespace grus::app
