// SPDX-License-Identifier: LGPL-3.0-or-later
// From a scene to the state in which its test begins, and what is told of that.
#pragma once

#include "apps/scene/rve_scene.hpp"
#include "dem/sample/prepare.hpp"

namespace grus::app {

using dem::StageWatch;

inline constexpr const char* no_bonds = "the scene has no bonds between grains";

/// The sample of a scene but for a random packing, which takes its time (none). Throws as dem::make does.
std::optional<dem::Sample> made_at_once(const RveScene& scene);

/// Interval of rows in s, and what is wrong with it or lacks for it, once the duration of the test is known.
void settle_rows(RveScene& scene);

/// Puts into the scene what only the sample tells: its notes, what reads the load, the times of a test between platens.
/// Throws InputError where output is asked for that there cannot be.
void settle(RveScene& scene, const dem::Sample& sample);

/// A sample as packed, and under the pressure of the scene's preparation.
struct Base {
  double packed_void_ratio = 0;
  dem::FoundDensity density = {};  // where a void ratio was asked for
  dem::State state;
};

/// `made`: the sample, where it is there already. Throws InputError where the packing cannot be, Unstable where the
/// pressure is not reached, Interrupted.
Base prepare_base(const RveScene& scene, const dem::Sample* made, dem::Team& team, const StageWatch& watch = {});

/// The packing as the preparation has made it: stresses asked and reached, void ratios before and after; null where
/// the scene has no preparation.
nlohmann::json tell_preparation(const RveScene& scene, double packed_void_ratio, const dem::State& state,
                                const std::optional<dem::Vec3>& stresses = {}, const dem::FoundDensity& density = {});

/// A note where void ratios, which nobody asked for, have changed in any of these; empty: in none.
std::string note_of_preparations(const std::vector<nlohmann::json>& told);

/// Several preparations in one: how many, least and largest void ratios and pressures, the worst error of a stress;
/// null: none is told.
nlohmann::json sum_of_preparations(const std::vector<nlohmann::json>& told);

/// The state in which the test of a scene begins: read, made, prepared. Throws as the above.
dem::State prepare_sample(const RveScene& scene, dem::Team& team, const StageWatch& watch = {});

}  // namespace grus::app
