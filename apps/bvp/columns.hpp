// SPDX-License-Identifier: LGPL-3.0-or-later
// Columns of history.csv of grus-bvp, but for those of its probes.
#pragma once

#include "apps/bvp/points.hpp"
#include "apps/run/column.hpp"

namespace grus::app {

/// The facts that say which columns there are.
struct MacroTold {
  const BvpScene& scene;
  const fem::Problem& problem;
  bool bonded;  // RVEs have bonds
};

/// All that a row is read of, worked out once.
struct MacroRow {
  // From the solver's report: columns that quasi-static and dynamic runs fill with their own.
  double increment = 0, time = 0, iterations = 0, cutbacks = 0, residual = 0, correction = 0, noise = 0, wall = 0;
  double kinetic_over_internal = 0, energy_error = 0;
  const fem::MacroEnergy* energy = nullptr;  // always there
  const fem::ExplicitStaticsReport* explicit_statics = nullptr;
  // From the problem: means over its volume, tension-positive; by boundary in turn three components.
  std::vector<double> reaction = {}, moved = {};           // N, m
  std::array<double, 6> strain{}, stress{};                // Pa
  std::array<double, 6> grains_strain{}, grains_stress{};  // Pa; over the points with grains
  double volume = 0, p = 0, q = 0, volumetric = 0;         // m^3, Pa, Pa
  double macro_work = 0, regularised = 0;                  // J
  // From the RVEs; 0 without.
  coupling::SweepReport sweep = {};
  double rves = 0, breakages = 0, bonds_broken = 0, worst_energy_error = 0, mass_lost = 0;
  double work = 0, unexplained = 0, haste = 0;  // J, of all points, by the volumes that they stand for
};

/// Columns that the summary reads again from the last row.
namespace macro_column {
double external_work(const MacroRow& row, std::size_t);
double damped(const MacroRow& row, std::size_t);
double scaled(const MacroRow& row, std::size_t);
double energy_error(const MacroRow& row, std::size_t);
double correction(const MacroRow& row, std::size_t);
double worst_unbalanced(const MacroRow& row, std::size_t);
double worst_stress_change(const MacroRow& row, std::size_t);
}  // namespace macro_column

using MacroColumn = Column<MacroRow>;
std::vector<MacroColumn> macro_columns(const MacroTold& told);

}  // namespace grus::app
