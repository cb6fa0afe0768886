// SPDX-License-Identifier: LGPL-3.0-or-later
// How the RVEs of a macro program answer, which of their work may be left out, and what is told of them: options and
// reports.
#pragma once

#include <algorithm>

#include "dem/rve/response.hpp"

namespace grus::dem {

enum class TangentKind {
  automatic,          // contact stiffness; the network where Newton stalls with it
  contact_stiffness,  // elastic contacts, sliding ones without k_t
  network,            // the contact network with grains free to move: relaxed, sliding contacts without k_t
  elastic,            // that of the first response, kept
  perturbation,       // from scratch copies
  quasi_newton        // Broyden's update from iteration to iteration and from increment to increment
};

/// How an RVE is taken through an increment.
enum class Pace : std::uint8_t {
  relaxed,    // to rest, from the committed state; may be refused
  real_time,  // in the time that the macro solver says; no way back
  steady      // by its own rate, without rest; no way back
};

/// The fate of an RVE that cannot go on, where there is no way back.
enum class OnFailure : std::uint8_t { stop, elastic };

/// How responses are made; the same on all ranks.
struct ResponseOptions {
  QuasiStatic quasi_static;
  TangentKind tangent = TangentKind::automatic;
  double perturbation = 1e-4;  // strain of the scratch copies
  bool central = false;
  double elastic = -1;  // share of the contact forces that may leave the linear range of an elastic point; below 0: off
  OnFailure on_failure = OnFailure::stop;
};

/// Work that may be left out. With everything off every point advances an RVE of its own at every response.
struct RveOptions {
  ResponseOptions response;
  Pace pace = Pace::relaxed;
  bool exact_sharing = true;  // points of one history have one RVE; the same bits as without
  double share = 0;           // similar sharing: largest difference of deformation gradients, over the history; 0: off
  double error = 0;           // deferral: largest predicted stress change relative to the stress, since the last commit
                              // or since this increment's last DEM answer; 0: off
};

/// Facts of a committed state that are known where it does not live.
struct Facts {
  double energy_error = 0, mass = 0, lost_mass = 0, void_ratio = 0;
  double work = 0, unexplained = 0;  // J, of the ledger
  double haste = 0;                  // J, of the work: the price of the cell's own rate; steady RVEs
  double local_damping = 0;          // J, of what is dissipated: by a device
  double bond_damping = 0;           // J, the same: by the dashpots of face bonds
  double scaled_inertia = 0;         // J, put in at births
  std::uint64_t grains = 0, breakages = 0, steps = 0;
  std::uint64_t bonds = 0, bonds_broken = 0;  // of faces; where the material has such bonds

  using Number = double Facts::*;
  using Count = std::uint64_t Facts::*;
};

/// How well a device keeps to its tolerance: errors measured whenever the truth comes out, relative to the stress.
struct MeasuredError {
  std::uint64_t count = 0;
  double worst = 0, sum = 0;
  void add(double error) {
    ++count;
    sum += error;
    worst = std::max(worst, error);
  }
  double mean() const { return count > 0 ? sum / static_cast<double>(count) : 0; }
};

/// Figures of the last commit and of everything since the start.
struct SweepReport {
  std::uint64_t asked = 0, advanced = 0, deferred = 0, elastic = 0, similar = 0, replayed = 0,
                retried = 0;  // answers; of them DEM runs, others
  std::uint64_t dem_steps = 0;
  std::uint64_t distinct = 0;               // RVEs now
  MeasuredError deferral, sharing, linear;  // prediction against what the RVE then did; at replays; of elastic points
  double least_trust = 1;                   // lowest share of the deferral tolerance that a slot was left with
  double correction = 0;                    // largest first-order correction of a similar point, relative to its stress
  double worst_unbalanced = 0, worst_stress_change = 0;  // of the last commit
  double inertial_number = 0;                            // mean of the steady RVEs in the last response
  std::uint64_t given_up = 0;                            // RVEs that answer with what is left of their stiffness
};

}  // namespace grus::dem
