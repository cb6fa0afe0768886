// SPDX-License-Identifier: LGPL-3.0-or-later
// Where each kind of macro run stands, as JSON with exact numbers, for checkpoints; and back.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "fem/explicit_statics.hpp"
#include "fem/statics.hpp"

namespace grus::app {

nlohmann::json save(const fem::IncrementReport& report);
nlohmann::json save(const fem::DynamicsReport& report);
nlohmann::json save(const fem::ExplicitStaticsReport& report);

void load(const nlohmann::json& at, fem::StaticsStart& start);
void load(const nlohmann::json& at, fem::DynamicsReport& start);
void load(const nlohmann::json& at, fem::ExplicitStaticsReport& start);

}  // namespace grus::app
