// SPDX-License-Identifier: LGPL-3.0-or-later
// The breakage pass: test every free grain, split those that fail, keep accelerations by cohesive springs, book the
// rest.
#pragma once

#include <memory>

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

struct Break {
  std::size_t grain;
  Wanted wanted;
  std::optional<Pieces> pieces = {};  // of a grain that was tested itself; none: its splitter makes them
  std::shared_ptr<const CrackedLattice> lattice = {};  // what it was tested on, where LatticeModel::tells_points
};

/// A grain is found before its load is this much beyond what it can bear, as far as loads go on as since the last test.
inline constexpr double overshoot = 0.02;

/// Grains that fail a criterion and whose shape may be split. Forces and torques must be up to date. Notes how near
/// each grain is to failing, and when to test next: after numerics.fracture_every steps, sooner where a load grows so
/// fast that a grain would overshoot. Where nothing fails, nothing is allocated.
std::vector<Break> find_breaks(const Model& model, State& state, Team& team);

/// Splits them; the neighbour list, contact forces and grains.force/torque are up to date again afterwards.
void apply_breaks(const Model& model, State& state, const std::vector<Break>& breaks, Team& team);

/// Strength factor of a new grain (its own Weibull draw); writes strength and leaves other columns alone.
void draw_strength(const Model& model, Grains& grains, std::size_t i);

}  // namespace grus::dem
