// SPDX-License-Identifier: LGPL-3.0-or-later
// Kicks and drifts of spheres, a grain's row of four at a time. Built for several instruction sets, as contact_pass.hpp.
#pragma once

#include <cstddef>
#include <cstdint>

namespace grus::dem {

/// Rows of other tiles may lie in another core's cache: they are asked for this many ahead. remote_row is longer by as much.
inline constexpr std::uint32_t rows_ahead = 16;

/// Rows of doubles, in the layout of the columns of the same names.
struct SphereSweep {
  double* motion;              // 12: position radius | velocity 1/m | spin 1/I
  double* load;                // 8: force, 0 | torque, 0; taken and cleared by a close
  double* elsewhere;           // the same; of grain i: rows remote_row[remote[i]] to remote_row[remote[i + 1]]
  const std::uint32_t *remote, *remote_row;
  double *force, *torque;      // 3 each: written by a close alone, read by an open alone
  double* angular_momentum;    // 3: written by a close alone
  const double* mass;
  double gravity[3];
  double affine[9];            // velocity gradient of the cell, column by column
  bool weighs, shears;         // gravity, affine are not zero
  double damping, dt;
};

/// Energies of the sweep (J), and the square of a bound of the speeds against the affine field.
struct SweepEnergy {
  double viscous = 0, work = 0, speed2 = 0;
};

enum class Kick { close, open, both };
using SphereKicks = SweepEnergy (*)(const SphereSweep&, Kick, std::size_t begin, std::size_t end);
SphereKicks sphere_kicks();

namespace lanes1 { SweepEnergy sphere_kicks(const SphereSweep&, Kick, std::size_t, std::size_t); }
namespace lanes4 { SweepEnergy sphere_kicks(const SphereSweep&, Kick, std::size_t, std::size_t); }
namespace lanes8 { SweepEnergy sphere_kicks(const SphereSweep&, Kick, std::size_t, std::size_t); }

}  // namespace grus::dem
