// SPDX-License-Identifier: LGPL-3.0-or-later
// Quasi-static loading by increments: Newton with a predictor, line search, cutbacks.
#pragma once

#include "fem/macro_energy.hpp"
#include "fem/problem.hpp"

namespace grus::fem {

/// How the increments' linear systems are solved, on all ranks of the problem: by factors (MUMPS), or by GMRES behind
/// algebraic multigrid, for meshes whose factors take too much memory.
enum class LinearMethod { direct, iterative };

struct StaticsOptions {
  int increments = 10;
  double tolerance = 1e-6;               // residual against the internal forces
  double displacement_tolerance = 1e-3;  // correction against the increment's largest displacement
  int max_iterations = 25;
  int acceleration = 5;           // iterations that Anderson acceleration remembers; 0: plain Newton
  int max_cutbacks = 6;           // in a row
  double cut = 0.25, grow = 1.5;  // of the increment, never above the one asked for
  double least = 1e-6;            // of the one asked for: smaller, and the load is not carried
  LinearMethod linear = LinearMethod::direct;
};

/// After each accepted increment.
struct IncrementReport {
  int increment;
  double load_factor;              // 0 to 1
  int iterations, cutbacks;        // Newton iterations; cutbacks before this increment was accepted
  double residual;                 // relative, of the free nodes
  double correction;               // relative displacement correction of the last iteration
  double noise;                    // of the material, when the increment was accepted
  std::string cut_reason;          // of the last cutback
  std::vector<double> residuals;   // of the predictor and of every iteration: how Newton contracts
  MacroEnergy energy;              // since the start; works of each increment by the trapezoidal rule
  double next_size;                // of the load factor
  int law_sweeps;                  // since the start
  double largest_force, stiffest;  // norm of all forces (N) and mean tangent (Pa): the largest so far
  double last_size;                // of the load factor, that the next predictor goes by; 0: none
  int linear_iterations = 0;       // since the last report; of direct solves none
  int linear_failures = 0;         // iterative solves since then that a direct one has stood in for
};

/// Where to go on from, after Problem::restore.
struct StaticsStart {
  double load_factor = 0, next_size = 0;
  int increments = 0, law_sweeps = 0;
  double largest_force = 0, stiffest = 0, last_size = 0;
  MacroEnergy energy = {};
};

struct StaticsResult {
  bool converged = false, stopped = false;  // stopped by the observer
  double load_factor = 0;
  std::string failure;
  int law_sweeps = 0;
};

/// Carries the load factor, which is the time of boundary histories, from 0 to 1. A state is committed only when
/// residual and displacement have converged, each to its tolerance or to the material's noise, whichever is larger. The
/// observer may end the run by returning false.
StaticsResult solve_statics(Problem& problem, Material& material, const StaticsOptions& options,
                            const std::function<bool(const IncrementReport&)>& observer,
                            const StaticsStart& start = {});

}  // namespace grus::fem
