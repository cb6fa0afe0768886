// SPDX-License-Identifier: LGPL-3.0-or-later
// The state: all that changes in a run, as values. A copy is a snapshot, and nothing else needs to be rolled back.
#pragma once

#include "dem/contact/neighbours.hpp"
#include "dem/kernel/sweep.hpp"
#include "dem/state/bonds.hpp"
#include "dem/state/ledger.hpp"

namespace grus::dem {

/// The servo of a test that holds a stress has learned this.
struct Servo {
  Vec3 drift = Vec3::Zero();      // 1/s, by axis: strain rate that keeps the stress where it is
  Vec3 stiffness = Vec3::Zero();  // Pa, by axis, of all contacts,
  Vec3 viscosity = Vec3::Zero();  // Pa s, and of their dashpots,
  std::uint64_t stale_at = 0;     // which are looked at again in this step
  double at = 0;                  // s, of the last correction
};

/// Room of the breakage test.
struct BreakRoom {
  std::vector<std::uint8_t> failing;  // by grain
  GrainBonds bonds;                   // of hulls
};

/// A contact of hulls that stiffens between two estimates of the critical step asks for one at once: firmer, then, as
/// soon as all runs of steps would notice alike, asked. Implicit steps read it their own way.
enum class StepWatch : std::uint8_t { on, firmer, asked, off };

struct State {
  Grains grains;
  Contacts contacts;
  Bonds bonds;
  Boundary boundary;
  Ledger ledger;
  NeighbourReference reference;
  std::vector<SweepEnergy> grain_energy;  // one a tile
  BreakRoom break_room;
  double time = 0, dt = 0;                   // s
  std::uint64_t steps = 0, grain_steps = 0;  // grain_steps: steps times grains, summed
  std::uint64_t next_estimate = 0,
                estimate_interval = 5;  // step at which the critical step is due again, and the gap to the next
  StepWatch watch = StepWatch::on;
  double skin = 0, mean_radius = 0;            // m; the radius at the start
  double grain_pressure = 0;                   // Pa; mean of the grains, kept while some may swell
  std::uint64_t tested_at = 0, next_test = 0;  // steps of the last and the next breakage test
  std::uint64_t listed_at = 0;                 // step at which the neighbour list ran out last
  std::uint64_t sorted = 0;                    // number of grains when they were last put in order
  Servo servo;
  bool resting = false;  // reduced to what cannot be made again (rve/resting.hpp)
};

}  // namespace grus::dem
