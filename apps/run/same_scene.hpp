// SPDX-License-Identifier: LGPL-3.0-or-later
// Whether a run that is resumed is of the scene that its checkpoint was made of.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace grus::app {

/// Throws InputError that names each key whose value has changed, with both values in SI units, where `now` is not
/// `kept`, the scene of the checkpoint at `path`. `of`: what the keys belong to, if not the scene itself. A title
/// decides nothing and may change.
void refuse_changes(const std::string& path, const nlohmann::json& kept, const nlohmann::json& now,
                    const std::string& of = "");

}  // namespace grus::app
