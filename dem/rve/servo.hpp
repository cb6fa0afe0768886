// SPDX-License-Identifier: LGPL-3.0-or-later
// The strain rates by which the axes of a test seek their stresses, and those of a cell hold them.
#pragma once

#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"

namespace grus::dem {

/// Steps between corrections, at most.
inline constexpr std::uint64_t servo_steps = 25;

/// The orders of the three axes at a time. Where a mean stress is held, or a true triaxial test has stresses to begin
/// at, all axes seek these at first, in proportion to time. Then the two that are not driven seek what the driven one
/// leaves of three times the mean, alike or by the ratio; and without a mean the middle one what the ratio says.
std::array<AxisControl, 3> controls(const Loading& loading, const Vec3& stress, double time);

/// Stress that an axis seeks (Pa, tension-positive).
double stress_asked(const AxisControl& axis, double time);

/// Rate (1/s) up to which an axis may move to hold its stress, whatever the test's own: grains that give way under a
/// pressure (Pa) do so in their own time.
double fastest_rate(const State& state, const AxisControl& axis, double pressure);

/// Strain rates of the axes (1/s) for the next `steps`, which it sets. Where the loading holds, a cell's axis goes by
/// what it has learned to need (state.servo) and by what closes the gap, and is corrected the more often the faster the
/// driven axis changes the stress; otherwise it closes the gap to a stress that is sought in two hundred steps.
Vec3 servo_rates(const Model& model, State& state, const Loading& loading, std::uint64_t& steps);

/// How far the stresses that axes seek are off: the largest |stress / sought - 1|; of a constant mean stress, that of
/// the mean too; of walls that seek one the same of their forces. NaN where nothing seeks a stress other than 0.
double stress_error(const State& state, const Loading& loading, const Measurement& m);

}  // namespace grus::dem
