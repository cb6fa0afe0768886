// SPDX-License-Identifier: LGPL-3.0-or-later
// Quasi-static problems without iterations: dynamic relaxation that follows the load, each element's mass scaled to one
// common step, local damping, and a rate of loading that keeps within limits of balance, kinetic energy and inertial
// number.
#pragma once

#include "fem/dynamics.hpp"

namespace grus::fem {

struct ExplicitStaticsOptions {
  double balance = 0.02;           // mean unbalanced force of free nodes / mean force applied at nodes
  double kinetic = 0.01;           // kinetic energy / energy in the material
  double inertial_number = 0;      // mean of the material's; 0: no limit
  double damping = 0.8;            // local, non-viscous: of the unbalanced force, against the velocity
  double safety = 0.9;             // of the step at which the stiffest mode of any element becomes unstable
  double crossings = 100;          // of the mesh by a wave, at least, while the load is set on
  int estimate_every = 20;         // steps between estimates of masses, and between changes of the rate
  double output_interval = 0.005;  // of the load factor, between reports
  double max_energy_error = 0.1;
  std::function<bool()> stop;  // asked after every step; true: the run ends there, to be gone on with; empty: never
  Wishes wishes;
};

/// The limit that rules the rate of loading.
enum class Governor : int { none, balance, kinetic, inertial_number };

/// All that the solver goes on with; between steps.
struct ExplicitStaticsReport {
  double load_factor = 0;
  double rate = 0;       // of the load factor, a step, before it is eased in or out
  double mean_rate = 0;  // as it was, averaged as the nodes' drift is
  std::uint64_t steps = 0, settling = 0,
                rested = 0;  // settling: before the load began to move; rested: after it came to its end
  MacroEnergy energy;        // a step ago
  double unbalanced = 0, largest_unbalanced = 0,
         inertial_number = 0;    // over the last interval: mean ratio, largest node's, mean
  std::array<double, 3> sums{};  // of these since the last change of the rate
  std::uint64_t counted = 0;     // steps in them
  Governor governor = Governor::none;
};

struct ExplicitStaticsResult {
  bool finished = false, stopped = false;
  ExplicitStaticsReport last;
  std::string failure;
};

/// Carries the load factor, which is the time of boundary histories, from 0 to 1, from rest or from `start` after
/// Problem::restore. The material answers each step and is committed; its time is its own (Points::duration = 0).
ExplicitStaticsResult solve_explicit_statics(Problem& problem, Material& material,
                                             const ExplicitStaticsOptions& options,
                                             const std::function<bool(const ExplicitStaticsReport&)>& observer,
                                             const ExplicitStaticsReport& start = {});

/// Steps that a wave needs to cross the mesh, at the common step of all elements.
double crossing_steps(Problem& problem, const ExplicitStaticsOptions& options);

}  // namespace grus::fem
