// SPDX-License-Identifier: LGPL-3.0-or-later
// Readings that a test takes of its sample: forces of walls, load and way, axial stress and strain. `first`: the state
// of the sample as it was made; `now`: the one that is read. Stresses are compression-positive (Pa).
#pragma once

#include "dem/rve/measure.hpp"
#include "dem/sample/programme.hpp"

namespace grus::dem {

/// The grains are in a box or cylinder of walls.
bool box_of_walls(const State& now);

/// The stress of the sample, from its walls where it has any (Pa, tension-positive).
const Mat3& sample_stress(const State& now, const Measurement& measured);

/// The test is in a box or between platens, which have a fixed and a moving face.
bool has_faces(const Programme& test, const State& now);

/// Stress on the fixed and on the moving face along the test's axis: walls of a box, or platens (force over the square
/// of the initial height).
std::array<double, 2> face_stresses(const Programme& test, const State& first, const State& now);

/// The stress that the test is about: walls and platens by their force, cells by Love-Weber.
double axial_stress(const Programme& test, const State& first, const State& now, const Measurement& measured);
/// The same of a state that is not measured otherwise.
double axial_stress(const Programme& test, const State& first, const State& now);

/// Compression along the test's axis: of the box or cell, or of the gap between platens.
double axial_strain(const Programme& test, const State& first, const State& now, const Mat3& initial_cell);

/// Whether the test is told by its q: at a constant mean stress, and of three stresses.
bool tells_q(const Programme& test);
/// Whether the test has a stress of its own, and it: nominal stress of a load on Voronoi cells, q at a constant mean
/// stress and of three stresses (0 without).
bool tells_stress(const Programme& test);
double test_stress(const Programme& test, const State& now, const Measurement& measured);

/// Whether there is a stress to tell: of a sample with a volume or between platens, or one of the test's own.
bool has_stress(const Programme& test, const State& now);

/// Load (N) and way (m) of what moves, along its motion.
double load_of(const Gauge& gauge, const State& now);
double way_of(const Gauge& gauge, const State& first, const State& now);

/// Dead loads move the grains, and no gauge tells of it.
bool dead_loaded(const Programme& test, const State& first);

/// The pull of dead loads along their sum (N), or along the first of them where they hold each other: of such each
/// half counts once. Empty: there are none, or something else moves the grains.
std::optional<double> dead_load(const Programme& test, const State& now);

/// The way (m) on which they do their work: of where they hold, by their shares.
double dead_way(const State& first, const State& now);

/// How to meet `final_stress`, which the test has; both must outlive what is returned.
Landing stress_landing(const Programme& test, const State& first);

/// Lode's angle (rad) of a stress that is tension-positive: 0 where the two lesser pressures are one, as in a triaxial
/// compression, pi / 3 where the two greater ones are.
double lode_angle(const Mat3& stress);

/// Norm of the deviator.
double deviator(const Mat3& m);

}  // namespace grus::dem
