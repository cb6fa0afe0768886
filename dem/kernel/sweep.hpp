// SPDX-License-Identifier: LGPL-3.0-or-later
// Kicks and drifts of grains. Built for several instruction sets, as contact_pass.hpp.
#pragma once

#include <cstddef>
#include <cstdint>

namespace grus::dem {

/// Rows of other tiles may lie in another core's cache: they are asked for this many ahead. remote_row is longer by as
/// much.
inline constexpr std::uint32_t rows_ahead = 16;

/// Rows of doubles, in the layout of the columns of the same names.
struct SweepRows {
  double* motion;     // 12: position radius | velocity 1/m | spin 1/I
  double* load;       // 8: force, 0 | torque, 0; taken and cleared by a close. Row 0 is that of grain `first`
  double* elsewhere;  // the same; of grain i: rows remote_row[remote[i]] to remote_row[remote[i + 1]]
  const std::uint32_t *remote, *remote_row;
  double *force, *torque;    // 3 each: written by a close alone, read by an open alone, and what bonds do
  double* angular_momentum;  // 3: of a sphere written by a close alone
  const double* mass;
  double* orientation;    // 4
  double* frame;          // 12: octant origin, axes column by column; none while all grains are spheres
  const double* inertia;  // 7: principal moments | rotation principal -> geometry
  const double* shape;    // 6: semi-axes plus, minus
  double gravity[3];
  double affine[9];             // velocity gradient of the cell, column by column
  bool weighs, shears, bonded;  // gravity, affine are not zero; force and torque hold what bonds do
  const double* damping;        // by material; nullptr: none damps
  const std::uint8_t* material;
  std::uint32_t first;
  double dt;
};

/// Energies of the sweep (J), and the square of a bound of the speeds against the affine field.
struct SweepEnergy {
  double viscous = 0, work = 0, speed2 = 0;
};

enum class Kick { close, open, both };

/// Spheres [begin, end), a grain's row of four at a time; their orientations are left to `turn_spheres`.
using SphereKicks = SweepEnergy (*)(const SweepRows&, Kick, std::size_t begin, std::size_t end);
/// Spheres and poly-ellipsoids, by symmetric-top splitting, as many at a time as a register holds.
using BodyKicks = SweepEnergy (*)(const SweepRows&, Kick, const std::uint32_t* grains, std::size_t count);
/// Spheres turn by their spin.
using SphereTurns = void (*)(const SweepRows&, const std::uint32_t* grains, std::size_t count);
SphereKicks sphere_kicks();
BodyKicks body_kicks();
SphereTurns sphere_turns();

#define GRUS_DECLARE_LANES(name)                                                                  \
  namespace name {                                                                                \
  SweepEnergy sphere_kicks(const SweepRows&, Kick, std::size_t begin, std::size_t end);           \
  SweepEnergy body_kicks(const SweepRows&, Kick, const std::uint32_t* grains, std::size_t count); \
  void sphere_turns(const SweepRows&, const std::uint32_t* grains, std::size_t count);            \
  }
GRUS_DECLARE_LANES(lanes1)
GRUS_DECLARE_LANES(lanes4)
GRUS_DECLARE_LANES(lanes8)
#undef GRUS_DECLARE_LANES

}  // namespace grus::dem
