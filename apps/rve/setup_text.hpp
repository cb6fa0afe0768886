// SPDX-License-Identifier: LGPL-3.0-or-later
// What a test of grains is like, as it is told before it begins and by --check.
#pragma once

#include <string>

#include "apps/rve/rehearsal.hpp"

namespace grus::app {

/// `grains`: of the whole sample, where the state is a piece of it. `found`: of those rehearsed; null: none was.
std::string setup_text(const RveScene& scene, const dem::State& s, double grains, const Rehearsal* found);

/// Throws InputError where the test would take more steps than anybody has time for.
void refuse_endless(const RveScene& scene, const dem::State& s);

}  // namespace grus::app
