// SPDX-License-Identifier: LGPL-3.0-or-later
// The breakage pass: test every free grain, split those that fail, keep accelerations by cohesive springs, book the rest.
#pragma once

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

struct Break {
  std::size_t grain;
  int axis;
  std::optional<Quat> orientation = std::nullopt;  // of a sphere whose axes turn before it splits
};

/// Grains that fail a criterion and whose shape may be split. Forces and torques must be up to date.
/// `room` is reused from test to test: where nothing fails, nothing is allocated.
std::vector<Break> find_breaks(const Model& model, const State& state, std::vector<std::uint8_t>& room, Team& team);
inline std::vector<Break> find_breaks(const Model& model, const State& state, Team& team) {
  std::vector<std::uint8_t> room;
  return find_breaks(model, state, room, team);
}

/// Splits them; the neighbour list, contact forces and grains.force/torque are up to date again afterwards.
void apply_breaks(const Model& model, State& state, const std::vector<Break>& breaks, Team& team);

/// Strength factor of a new grain (its own Weibull draw); writes strength and leaves other columns alone.
void draw_strength(const Model& model, Grains& grains, std::size_t i);

}  // namespace grus::dem
