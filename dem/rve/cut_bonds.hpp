// SPDX-License-Identifier: LGPL-3.0-or-later
// Bonds of a hull that is cut in two go to its halves, which get one between them; what acts on one that falls into
// many goes to these.
#pragma once

#include <span>

#include "dem/rve/fresh_springs.hpp"

namespace grus::dem {

/// Bonds, bonds with walls and dead loads of grain i go over to its pieces, those that the cut meets in two parts.
/// `second`: the slot of the second piece; the first keeps the parent's, which is still what it was.
void cut_bonds(const Pieces& pieces, Index i, Index second, State& state);

/// Pieces that no bond holds: each dead load of grain i goes to the piece that its point is in, and the fresh faces are
/// booked. `second`: as above; the others follow it.
void share_out(const Pieces& pieces, Index i, Index second, State& state);

/// Once the pieces are there: the bond of the fresh face, which bears nothing yet, and dashpots by the pieces' masses.
void join_pieces(const Model& model, const Pieces& pieces, std::span<const std::size_t> slots, State& state);

/// Lets that bond bear what makes both pieces go on as their parent: forces of all else must be up to date. What it
/// cannot is booked as residual. Returns what it holds (J).
double load_cap(State& state, const ParentMotion& parent, const FreshFace& face, std::span<const std::size_t> slots);

/// Held by face bonds and bonds with walls of the marked grains (J).
double bond_energy_of(const State& state, std::span<const std::uint8_t> among);

/// Crystals of grains that cleave along planes, where there are none yet.
void draw_crystals(const Model& model, Grains& grains);

}  // namespace grus::dem
