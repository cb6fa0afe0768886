// SPDX-License-Identifier: LGPL-3.0-or-later
// Runs that go on: from a checkpoint of their own scene, which may now go further, or from the last state of another.
#pragma once

#include "apps/run/command.hpp"
#include "apps/scene/rve_scene.hpp"
#include "dem/io/checkpoint.hpp"
#include "dem/sample/make.hpp"

namespace grus::app {

/// The checkpoint of a run of this scene, or of one that went less far. Throws InputError where there is none, or one
/// of another scene.
dem::Checkpoint find_checkpoint(const Options& options, const RveScene& scene);

/// Rows of history.csv as they would be, had the stages been there that are since: their columns tell of no cycle and
/// of no stress that is held.
std::string with_columns(const std::string& rows, const std::vector<std::string>& columns);

/// Refuses to write into the folder of the run that the scene starts from.
void refuse_own_start(const Options& options, const RveScene& scene);

/// The last state of the run that the scene starts from, at rest as its walls and cell are, ready to be loaded: clock
/// and ledger start at zero. Throws InputError where that run had another sample, or failed; notes that it was stopped.
dem::State start_of(RveScene& scene, const dem::Sample& sample, dem::Team& team);

}  // namespace grus::app
