// SPDX-License-Identifier: LGPL-3.0-or-later
// Columns and rows of history.csv of grus-rve.
#pragma once

#include "apps/scene/rve_scene.hpp"
#include "dem/rve/measure.hpp"

namespace grus::app {

std::vector<std::string> rve_columns(const RveScene& scene, const dem::State& state);

/// One row, in the order of rve_columns.
std::vector<double> rve_row(const RveScene& scene, const dem::State& state, const dem::Measurement& m,
                            const dem::Mat3& initial_cell);

/// Whether the test has a stress of its own, and it: nominal stress of a load on cells, q at a constant mean stress
/// (Pa; 0 without).
bool tells_stress(const RveScene& scene);
double test_stress(const RveScene& scene, const dem::State& state, const dem::Measurement& measured);

/// Whether there is a stress to tell: of a sample with a volume or between platens, or one of the test's own.
bool has_stress(const RveScene& scene, const dem::State& state);

/// What dead loads pull with along their sum (N); empty: there are none, or something else moves the grains.
std::optional<double> dead_load(const RveScene& scene, const dem::State& state);

/// The compression-positive stress that the test is about: walls and platens by their force, cells by Love-Weber (Pa).
double axial_stress(const RveScene& scene, const dem::State& state, const dem::Measurement& m);
/// The same of a state that is not measured otherwise.
double axial_stress(const RveScene& scene, const dem::State& state);

/// Compression along the test's axis: of the box or cell, or of the gap between platens.
double axial_strain(const RveScene& scene, const dem::State& state, const dem::Mat3& initial_cell);

}  // namespace grus::app
