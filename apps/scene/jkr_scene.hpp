// SPDX-License-Identifier: LGPL-3.0-or-later
// [material.NAME] contact = "jkr".
#pragma once

#include "apps/scene/reader.hpp"
#include "dem/rve/model.hpp"

namespace grus::app {

/// Reads what the law asks of a material. Refuses grains that break: it presses spheres alone.
void read_jkr(Table& table, dem::Material& material);

/// Refuses grains that attraction alone would press so deep into each other that their circles of contact are no longer
/// small against them.
void refuse_sunk(const Table& table, const dem::Material& material, double radius, const std::string& key);

}  // namespace grus::app
