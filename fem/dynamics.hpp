// SPDX-License-Identifier: LGPL-3.0-or-later
// Explicit dynamics: central differences, lumped mass, a stable step from the elements' own eigenvalues, an energy
// balance.
#pragma once

#include "fem/macro_energy.hpp"
#include "fem/problem.hpp"

namespace grus::fem {

/// Of a problem with exact sums, on many ranks: three bits that each rank tells once a step, and what any has told,
/// heard before `stop` is asked. They travel with what the step has to ask anyway. Empty: nothing is told.
struct Wishes {
  std::function<int()> tell;
  std::function<void(int)> hear;
};

struct DynamicsOptions {
  double duration = 0;          // s
  double safety = 0.8;          // of the stable step
  double time_step = 0;         // s; 0: from the stable step
  double linear_viscosity = 0;  // bulk viscosity, of rho c h; acts in compression only
  double quadratic_viscosity = 0;
  int estimate_every = 50;        // steps between estimates of the stable step (and tangents of the material)
  double output_interval = 0;     // s between reports
  double max_energy_error = 0.1;  // beyond it the run has become unstable
  std::function<bool()> stop;     // asked after every step; true: the run ends there, to be gone on with; empty: never
  Wishes wishes;
};

struct DynamicsReport {
  double time = 0, dt = 0;  // s
  std::uint64_t steps = 0;
  MacroEnergy energy;     // a step ago, when all of it is known
  double dissipated = 0;  // by bulk viscosity in the last step (J)
};

struct DynamicsResult {
  bool finished = false, stopped = false;  // stopped by the observer, or between two of its calls
  DynamicsReport last;
  std::string failure;
};

/// Integrates from rest, or from `start` after Problem::restore. `density` (kg/m^3, reference configuration) is that of
/// every owned point. The material answers for real time (Points::duration) and is committed at every step.
DynamicsResult solve_dynamics(Problem& problem, Material& material, const std::vector<double>& density,
                              const DynamicsOptions& options,
                              const std::function<bool(const DynamicsReport&)>& observer,
                              const DynamicsReport& start = {});

/// Largest step (s) with which central differences are stable: 2 / the largest eigenfrequency of any single element,
/// which bounds that of the mesh. Uses the present tangents.
double stable_step(Problem& problem, const std::vector<double>& density);
/// The same before any material has answered: with `tangent` (Pa, 6 x 6 a point) for what its materials will say.
double stable_step(Problem& problem, const std::vector<double>& density, const std::vector<double>& tangent);

/// Step (s) that a run takes where the stable one is known: with its safety, and less where bulk viscosity acts.
double step_taken(const DynamicsOptions& options, double stable);

}  // namespace grus::fem
