// SPDX-License-Identifier: LGPL-3.0-or-later
// A state as bytes and back.
#pragma once

#include <memory>

#include "dem/io/walk.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

template <>
inline constexpr bool made_again<Plan> = true;  // by entail
template <>
inline constexpr bool made_again<HullGuesses> = true;  // by the next step
template <>
inline constexpr bool made_again<PairIndex> = true;  // by index_grains
template <>
inline constexpr bool made_again<NeighbourRoom> = true;
template <>
inline constexpr bool made_again<BondTiles> = true;
template <>
inline constexpr bool made_again<FaceOutlines> = true;
template <>
inline constexpr bool made_again<BreakRoom> = true;
template <>
inline constexpr bool made_again<TriangleGrid> = true;  // by surface_of

/// What states share is with each of them: a checkpoint needs nothing else.
template <class A, class P>
requires std::is_same_v<std::remove_const_t<P>, std::shared_ptr<const HullStore>>
void walk_shared(A& a, P& shared) {
  HullStore store = shared ? *shared : HullStore{};
  walk(a, store);
  if constexpr (!std::is_const_v<P>)
    shared = store.row.empty() ? nullptr : std::make_shared<HullStore>(std::move(store));
}

template <class A, class P>
requires std::is_same_v<std::remove_const_t<P>, std::shared_ptr<const Triangles>>
void walk_shared(A& a, P& shared) {
  Triangles surface = shared ? *shared : Triangles{};
  walk(a, surface);
  for (const auto& t : surface.triangle)
    for (const Index corner : t)
      if (corner >= surface.corner.size()) throw InputError("checkpoint is damaged: a wall of triangles");
  if constexpr (!std::is_const_v<P>)
    shared = std::make_shared<Triangles>(surface_of(std::move(surface.corner), surface.triangle));
}

/// The number of all that is walked in a state.
std::uint64_t layout_of_states();

std::string bytes_of(const State& state);

/// The state that the bytes are of: equal in all that a run reads. Throws InputError where the bytes end too early or
/// too late, and for a list of pairs that is none.
State state_of(std::string_view bytes);

/// What follows from the list of pairs, of a state whose members were walked. Throws InputError for a list that is
/// none.
void make_again(State& state);

}  // namespace grus::dem
