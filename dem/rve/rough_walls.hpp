// SPDX-License-Identifier: LGPL-3.0-or-later
// Rough walls: grains that move with a plane as one body. They have no inverse mass, meet neither one another nor
// walls, and what free grains do to them is the wall's.
#pragma once

#include <algorithm>

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

inline bool rough(const Wall& wall) { return !wall.grains.empty(); }
/// Whether grains of a material move with the wall.
inline bool moves_with(const Wall& wall, std::uint8_t material) {
  return std::find(wall.grains.begin(), wall.grains.end(), material) != wall.grains.end();
}
bool any_rough(const Boundary& boundary);
bool any_rough_moves(const Boundary& boundary);

/// Grain i keeps its place and its orientation against a wall that has the velocity.
void fix(Grains& grains, std::size_t i, const Vec3& velocity);

/// Grains of rough walls get the velocity that their wall has now; the kinetic energy that it takes is work.
void carry_rough_walls(State& state);

/// The power of what moves rough walls, on free grains and against their own grains' weight (W).
double rough_power(const Model& model, const State& state);

/// The force of free grains on those of a wall (N).
Vec3 rough_force(const State& state, std::size_t wall);

/// From grain i of a rough wall to the wall's plane, along its normal (m).
Vec3 to_plane(const State& state, std::size_t i);

/// Calls f(k, is_b) for contacts k of a free grain with one that moves with the wall; is_b: the latter is the second.
template <class F>
void each_rough_contact(const State& s, std::size_t wall, F&& f) {
  const Wall& held = s.boundary.walls[wall];
  if (!rough(held)) return;
  for (std::size_t k = 0; k < s.contacts.begin[first_wall]; ++k) {
    if (!s.contacts.contact.touching(k)) continue;
    const Pair& p = s.contacts.pair[k];
    const bool b = moves_with(held, s.grains.material[p.b]);
    if (b || moves_with(held, s.grains.material[p.a])) f(k, b);
  }
}

}  // namespace grus::dem
