// SPDX-License-Identifier: LGPL-3.0-or-later
// Which grains peridynamics is asked about, and what follows from its answers.
#pragma once

#include "dem/fracture/hull_loads.hpp"
#include "dem/fracture/lattice_crack.hpp"
#include "dem/rve/breakage.hpp"

namespace grus::dem {

/// Hull i under its load, as LoadedHull asks.
LoadedHull loaded_hull(const Model& model, const State& state, std::size_t i);

/// Asks grain i under its load whether it cracks, whatever `worth_a_test` says. Contacts and bonds are indexed by
/// grain.
CrackResult ask_for_cracks(const Model& model, const State& state, std::size_t i);

/// Whether a grain whose force is `utilisation` of its platen strength is worth a test: it is near enough to it, at
/// rest, and bears other forces than when it last held. In order of cost.
bool worth_a_test(const Model& model, const State& state, std::size_t i, double utilisation);

/// Tests grains (in rising order), as tasks of the team; those that crack into more than one piece are breaks, in the
/// same order. Notes what the others bore, and books all in the ledger: the same whatever the threads.
std::vector<Break> crack_breaks(const Model& model, State& state, const std::vector<Index>& asked, Team& team);

}  // namespace grus::dem
