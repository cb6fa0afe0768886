// SPDX-License-Identifier: LGPL-3.0-or-later
// [preparation]: what a sample is compressed to before the test begins.
#pragma once

#include "apps/scene/reader.hpp"
#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// Reads it into the recipe, if it is there; the scene has its pair laws. Throws InputError, also where no packing of
/// such grains can bear the pressure.
void read_preparation(Table& table, RveScene& scene);

}  // namespace grus::app
