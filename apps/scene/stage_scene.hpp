// SPDX-License-Identifier: LGPL-3.0-or-later
// [[stage]]: a test of several stages, in place of [loading].
#pragma once

#include "apps/scene/reader.hpp"
#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// Reads them into the programme; the sample's tables are read. Throws InputError.
void read_stages(Table& table, RveScene& scene);

/// Rows that history.csv will have; a stage that ends by a stress may have a few more.
double rows_of(const dem::Programme& test);

/// How long the test takes at most (s); none where a stress or rest ends some stage.
std::optional<double> known_duration(const dem::Programme& test);

}  // namespace grus::app
