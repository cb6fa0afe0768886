// SPDX-License-Identifier: LGPL-3.0-or-later
// Kick-drift-kick on velocity and world angular momentum; rotation by symmetric-top splitting.
#pragma once

#include <span>

#include "dem/base/parallel.hpp"
#include "dem/kernel/sweep.hpp"
#include "dem/state/boundary.hpp"
#include "dem/state/contacts.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

struct MotionSettings {
  Vec3 gravity = Vec3::Zero();  // m/s^2
  std::span<const double>
      damping;  // by material, local non-viscous: -alpha |F| v / |v|, v against the cell's affine motion; empty: none
  bool turn_spheres = true;    // keep the orientation of spheres: needed to break or to report them
  Mat3 affine = Mat3::Zero();  // velocity gradient of the cell (1/s); kept by the step loop
};

/// One sweep over the grains. A close takes the loads of the contact pass (and what `bond_forces` left in
/// grains.force/torque) and kicks by dt/2; an open kicks by dt/2 and drifts. A step in the middle of a run does both at
/// once and leaves grains.force and torque alone; the two half kicks are rounded apart, so stopping between steps
/// changes no bit. Spheres turn by their spin; their angular momentum is written when a step is closed. Other bodies
/// turn freely for dt, by their angular momentum: half a step about x, as a symmetric top about z, half a step about x.
/// `energy`: one entry a tile.
class SweepPass {
public:
  SweepPass(Kick kick, Grains& grains, Contacts& contacts, const MotionSettings& settings, bool bonded, double dt,
            std::vector<SweepEnergy>& energy);
  /// `room`: where the tile's grains have collected; see ContactPass.
  void tile(std::size_t t, Load* room = nullptr) const;

private:
  Kick kick_;
  Grains& grains_;
  Contacts& contacts_;
  std::vector<SweepEnergy>& energy_;
  bool turning_;  // spheres too
  SweepRows rows_;
  SphereKicks spheres_;
  BodyKicks bodies_;
  SphereTurns turns_;
};

/// The whole sweep.
void sweep(Kick kick, Grains& grains, Contacts& contacts, const MotionSettings& settings, bool bonded, double dt,
           std::vector<SweepEnergy>& energy, Team& team);

/// Largest speed (m/s) since it was last asked for.
double take_speed(std::vector<SweepEnergy>& energy);

/// Walls and cell by dt.
void move_boundary(Boundary& boundary, double dt);

}  // namespace grus::dem
