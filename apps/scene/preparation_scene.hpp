// SPDX-License-Identifier: LGPL-3.0-or-later
// [preparation]: what a sample is compressed to before the test begins.
#pragma once

#include "apps/scene/reader.hpp"
#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// Why no packing of the scene's grains can bear a pressure (Pa); empty: some may.
std::string unbearable(const RveScene& scene, double pressure);

/// Reads it into scene.preparation, if it is there; the scene has its sample and pair laws. Throws InputError, also
/// where no packing of such grains can bear the pressure.
void read_preparation(Table& table, RveScene& scene);

}  // namespace grus::app
