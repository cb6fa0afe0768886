// SPDX-License-Identifier: LGPL-3.0-or-later
// The energy balance of a macro problem, whatever solves it.
#pragma once

namespace grus::fem {

/// Energies (J), each computed on its own. Kinetic: of the velocities at the instant of the positions. Internal: what
/// the materials hold and have spent, by their states. Viscous: pressure times compression rate, summed over the steps.
/// External: work of loads and of the reactions to prescribed motion. The balance tests them all; of an explicit step
/// beyond the critical one it says so at once. Increments have no kinetic, viscous, damped and scaled part; a load that
/// is there from their start on, and out of balance with the stress, counts as set on within the first.
struct MacroEnergy {
  double kinetic = 0, internal = 0, external = 0, viscous = 0;
  double work =
      0;  // of the internal forces, bulk viscosity left out: with `internal` it is the test of Hill and Mandel
  double largest = 0;    // of any of them so far: a bar that swings back holds nothing for a moment
  double damped = 0;     // by local damping
  double scaled = 0;     // added with mass that was scaled up in motion
  double error() const;  // (external - kinetic - internal - viscous - damped + scaled) / largest
  void note_largest();
  double kinetic_over_internal() const;  // of the larger of internal and external
};

}  // namespace grus::fem
