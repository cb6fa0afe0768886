// SPDX-License-Identifier: LGPL-3.0-or-later
// Whether a run that is resumed is of the scene that its checkpoint was made of.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace grus::app {

/// Throws InputError that names each key whose value has changed, with both values in SI units, where `now` is not
/// `kept`, the scene of the checkpoint at `path`. Defaults that come or go with another key are left out. `of`: what
/// the keys belong to, if not the scene itself; `advice`: what to do. A title decides nothing and may change.
void refuse_changes(const std::string& path, const nlohmann::json& kept, const nlohmann::json& now,
                    const std::string& of = "", const std::string& advice = "set it back, or begin anew with --force");

/// Whether summary.json of a results folder tells of a run that has finished: of this scene, if one is given, which may
/// have another title.
bool has_finished(const std::string& folder, const nlohmann::json* scene = nullptr);

/// What is said where such a run goes on from an older checkpoint.
inline constexpr const char* finished_before =
    "  note: this run has finished; what came after its checkpoint is computed again";

}  // namespace grus::app
