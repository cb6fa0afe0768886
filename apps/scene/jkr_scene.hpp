// SPDX-License-Identifier: LGPL-3.0-or-later
// [material.NAME] contact = "jkr".
#pragma once

#include "apps/scene/reader.hpp"
#include "dem/rve/model.hpp"

namespace grus::app {

/// Reads what the law asks of a material. Refuses grains that break: it presses spheres alone.
void read_jkr(Table& table, dem::Material& material);

}  // namespace grus::app
