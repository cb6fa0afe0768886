// SPDX-License-Identifier: LGPL-3.0-or-later
// Grain surfaces with per-grain fields, as a VTKHDF frame.
#pragma once

#include <memory>
#include <string>

#include "dem/fracture/lattice_crack.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// One frame: triangulated surfaces (512 triangles a grain, fewer of more than 2,000) and the outline of periodic cell
/// or box as lines; fields of VTK cells id, radius, speed, velocity, generation, material, coordination and mean
/// pressure of the grain (Pa, compression-positive), NaN on the outline. `wrapped`: grains with their centres in the
/// periodic cell.
void write_grains(const std::string& path, const State& state, bool wrapped = false);

/// Walls that are surfaces of triangles, where they are: each triangle with its wall and that one's force and velocity.
bool has_meshes(const State& state);
void write_walls(const std::string& path, const State& state);

/// The contact network: a line for each touching pair, between the centres of two grains (of a wall: to the contact),
/// with normal_force_N, tangential_force_N (magnitudes), force_N (on the second grain) and overlap_m. Needs contacts
/// that show their forces, as at the end of a run of steps.
void write_contacts(const std::string& path, const State& state, bool wrapped = false);

/// A grain that cracks, point by point.
struct CrackedGrain {
  double time;    // s
  Vec3 position;  // of its mass centre (m)
  Quat axes;      // of its frame
  std::shared_ptr<const CrackedLattice> lattice;
};

/// Its points where the grain is, each a vertex, as they were when its crack run ended: with damage, piece, dilation
/// and displacement_m.
void write_lattice(const std::string& path, const CrackedGrain& grain);

}  // namespace grus::dem
