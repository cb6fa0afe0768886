// SPDX-License-Identifier: LGPL-3.0-or-later
// Strain and stress programmes of a standalone test: what each axis of a box or cell is told to do.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "dem/base/watch.hpp"
#include "dem/rve/rve.hpp"

namespace grus::dem {

/// An axis follows a constant rate of engineering strain of the initial size, or seeks a normal stress.
struct AxisControl {
  double strain_rate = 0;        // 1/s, tension-positive; of an axis that seeks a stress what it does at no gap
  std::optional<double> stress;  // Pa, tension-positive; the rate is then bounded by max_rate
  double max_rate = 0;           // 1/s
  double stress_rate = 0;        // Pa/s, by which the stress goes on
};

/// A plane wall that seeks a stress on the area before it, by itself: see rve/press.hpp.
struct WallControl {
  std::size_t wall = 0;
  double stress = 0;       // Pa, compression-positive
  double stress_rate = 0;  // Pa/s, by which the stress goes on
  double area = 0;         // m^2; 0: the section of the box, as it is
  double max_speed = 0;    // m/s, inward and, beside what pushes it, outward; 0: as quasi-static loading bears
};

struct Loading {
  bool driven = false;                  // false: walls keep the velocities they were given, and `axes` is not read
  std::vector<WallControl> walls = {};  // beside such walls
  std::array<AxisControl, 3> axes;
  std::optional<Mat3> velocity_gradient;  // 1/s, periodic cell: replaces the axes
  std::optional<double> mean;             // Pa, tension-positive: the two axes without a rate keep the mean stress
  std::optional<Vec3> first;              // Pa, tension-positive, by axis: what a true triaxial test begins at
  std::optional<double> ratio;       // b = (middle - third) / (driven - third): the middle axis follows the other two
  int middle = 1;                    // that axis
  double consolidation = 0;          // s, in which all axes are first brought there, at no more than their max_rate
  double prepared = 0;               // Pa, tension-positive: the pressure that they have before
  bool isochoric = false;            // the two axes beside the one with a rate keep the volume
  bool holds = false;                // stresses are held against axes that are driven: see rve/servo.hpp
  Vec3 initial_size = Vec3::Zero();  // m, of the box or cell; set by begin_loading
};

/// Lengths of the box along its axes, or of the cell's edges along them (m).
Vec3 size_of(const Boundary& boundary);

/// Rate (1/s) at which an axis is strained now, of its size at the start of the test.
double axis_rate(const State& state, const Loading& loading, int axis);

/// Nothing but what it seeks moves a wall or the cell.
inline bool commands(const Loading& loading) { return loading.driven || !loading.walls.empty(); }

/// Notes the initial size and starts the motion of walls or cell.
void begin_loading(const Model& model, State& state, Loading& loading);

/// Starts the motion of walls or cell anew, as another loading goes on with a test; sizes and ledger stay.
void turn_loading(const Model& model, State& state, const Loading& loading);

/// A stress that ends a test, met within a step or so: how far off it is (Pa; 0 or less: reached) is looked at every
/// few steps, and from `near` (Pa) on after no more steps than the stiffness of all contacts needs to get there.
struct Landing {
  std::function<double(const State&)> left = {};
  double near = 0;
  int axis = 0;
};

/// True where so long a time (s) takes more steps than a machine of today gets through in months.
bool endless(const State& state, double duration);

/// Advances to the time `end` (s), exactly, or to where it has landed; servo axes are corrected every few steps. False:
/// the watch, which is asked every few steps, said to stop; going on later, from the state as it is, to the same end
/// changes no bit.
bool load(const Model& model, State& state, const Loading& loading, double end, Team& team, const Watch& watch = {},
          const Landing& landing = {});

/// Displacement gradient F - 1 of the box or cell since begin_loading; walls: diagonal.
Mat3 displacement_gradient(const State& state, const Loading& loading, const Mat3& initial_cell);

/// Each normal stress that a preparation reaches is within this of the one asked.
inline constexpr double compress_tolerance = 0.03;

/// A pressure (Pa) that contacts of such materials cannot bear within the model's overlap_limit and before the voids
/// are gone, whatever the packing: several times what spheres of fourteen neighbours each carry then. `radius`: of the
/// smallest grain (m). Infinite for hulls, whose contacts are not known beforehand.
double unbearable_pressure(const Model& model, double radius);

/// Cell and walls move no more.
void stand(State& state);

/// Compresses a prepared state of a periodic cell, or between six walls, to normal stresses along the axes (Pa,
/// compression-positive), each within compress_tolerance, without breakage, and holds it there. Throws Unstable where
/// they are not reached, or only by contacts deeper than overlap_limit or without voids where there were some;
/// Interrupted where the watch says so.
void compress(const Model& model, const QuasiStatic& options, State& state, const Vec3& stresses, Team& team,
              const Watch& watch = {});

/// The same to an isotropic pressure (Pa).
void compress_isotropically(const Model& model, const QuasiStatic& options, State& state, double pressure, Team& team,
                            const Watch& watch = {});

}  // namespace grus::dem
