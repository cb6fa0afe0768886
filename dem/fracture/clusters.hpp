// SPDX-License-Identifier: LGPL-3.0-or-later
// Into which pieces the points of a cracked grain fall.
#pragma once

#include "dem/fracture/peridynamic.hpp"

namespace grus::dem {

/// Share of each point's bonds that are broken, by weight.
std::vector<double> damage_of(const PeridynamicSolid& solid);

/// Pieces of points, the largest first, and after them the crumbs: clusters too small for a piece; -1: of none.
struct Clusters {
  std::vector<int> piece;
  int pieces = 0, crumbs = 0;
};

/// Points that have lost more than 0.35 of their bonds are set aside; the rest are joined over intact bonds to nearest
/// neighbours. Clusters of less than `least` of all points are set aside too, or with `crumbs` are such if they have
/// four points. Bonds alone would not do: some hold on across a crack for long, and much of the grain would be dust.
Clusters clusters_of(const PeridynamicSolid& solid, double least, bool crumbs = false);

/// Points told apart by where they have gone: those that move with the farthest, and the rest, where the first are a
/// piece, or with `crumbs` four points at least. What a contact has torn out is found so: bonds under it do not break,
/// and around it all are damaged.
Clusters torn_apart(const PeridynamicSolid& solid, const PointColumns& u, double least, bool crumbs = false);

/// What was set aside goes to the nearest piece, from neighbour to neighbour: over intact bonds while there are any,
/// then over all.
void attach(const PeridynamicSolid& solid, Clusters& clusters);

}  // namespace grus::dem
