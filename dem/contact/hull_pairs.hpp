// SPDX-License-Identifier: LGPL-3.0-or-later
// Pairs of convex hulls, and hulls at walls: rows of the table of pairs.
#pragma once

#include "dem/contact/hull_overlaps.hpp"
#include "dem/contact/pair_kinds.hpp"

namespace grus::dem {

/// The passes; see PairKind.
void hulls(const TileWork& work, std::size_t begin, std::size_t end);
void hulls_at_walls(const TileWork& work, std::size_t begin, std::size_t end);

/// Separation test; see PairKind.
bool hulls_near(const Grains& grains, const Cell& cell, const Candidate& pair, double skin, Vec3& normal);

/// The overlap of a listed pair of hulls, or of a hull and a wall, in the global frame about the mass centre of a, for
/// a modulus of 1. `search` and `guess` as overlap_of, global. Frames must be up to date.
Overlap overlap_of_pair(const Grains& grains, const Cell& cell, const Pair& pair, const Vec3& search,
                        HullGuess* guess = nullptr);
Overlap overlap_at_wall(const Grains& grains, const Wall& wall, Index grain);

/// Hulls one in the other press nowhere.
bool presses(const Overlap& overlap);

/// The overlap that a listed pair would have once it meets along `normal`, from a to b, and is pressed by `press` (m);
/// none where they are further apart along it than `reach` and `press` (m).
Overlap overlap_if_pressed(const Grains& grains, const Cell& cell, const Pair& pair, const Vec3& normal, double reach,
                           double press);

/// Velocity along n that an impulse of 1 along n gives to hull i at `arm` from its mass centre (1/kg). A blow on the
/// rim of a flake meets a small part of its mass: dashpots by the whole would throw it back.
double mobility(const Grains& grains, Index i, const Vec3& arm, const Vec3& n);

/// The largest inverse of a principal moment of hull i where grains have got mass and moments apart: a face may turn
/// faster what it shifts slowly. 0 elsewhere, where shifts tell enough.
double turned_apart(const Grains& grains, Index i);

/// How much more a contact of hulls resists a further overlap than modulus x area. Its potential is of some degree n in
/// the overlap, 2 of faces, 3 of an edge, 4 of a corner; volume and area are of n - 1 and n - 2, so the slope of its
/// force is c x area x |force| / volume: 1 of faces, 1.37 at a cube's corner, 2 at a blunt one.
double sharpness(double volume, double force);

/// Modulus (Pa/m) of the foundation between two hulls, and of one against a wall.
double foundation_of(const PairLaw& p, const Grains& grains, Index a, Index b);
double foundation_of(const PairLaw& p, const Grains& grains, Index a);

}  // namespace grus::dem
