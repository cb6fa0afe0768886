// SPDX-License-Identifier: LGPL-3.0-or-later
// Voronoi cells as grains, and the bonds of the faces that they share.
#pragma once

#include <span>

#include "dem/packing/shared_faces.hpp"
#include "dem/packing/voronoi.hpp"
#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// A face of a Voronoi cell on the outside of all.
struct OuterFace {
  Index grain;
  FaceMoments face;
  Vec3 normal;   // outward
  double depth;  // of the seed (m)
};

/// Counts of what became of the faces that Voronoi cells share.
struct BondedFaces {
  std::size_t bonds = 0;
  std::size_t unbonded = 0;  // smaller than 1e-6 of the Voronoi cells' distance squared
  std::size_t coarse = 0;    // too far apart for the energy: of less tension than asked for
  std::vector<OuterFace> outer;
};

/// Puts Voronoi cells into the state as hulls of a material, at rest, and bonds of its kind on the faces they share
/// (none without a bond model). The faces' numbers are those of the cells. Throws InputError.
BondedFaces add_voronoi_grains(const Model& model, const Tessellation& cells, std::uint8_t material, State& state);

/// The same of bodies from elsewhere, each of its material, with the faces that were found shared. `middles`: seeds or
/// mass centres, between which bonds are as long as they are apart along the face's normal. Where two materials meet
/// the bond is as strong as the weaker one's, and as stiff as half of each in a row. A face that is shared in part is
/// no outer face.
BondedFaces add_bodies(const Model& model, std::span<const Polyhedron> bodies, std::span<const Vec3> middles,
                       std::span<const std::uint8_t> materials, const SharedFaces& shared, State& state);

/// Those that look along a unit vector and lie furthest out along it, in one plane; `offset`: where (m).
std::vector<OuterFace> faces_towards(std::span<const OuterFace> outer, const Vec3& direction, double& offset);

/// Glues faces to a wall by bonds that never break: half of what would hold them to their mirror images, so that a
/// homogeneous strain goes on to the wall. `slides`: without shear and twist.
void glue(const Model& model, std::span<const OuterFace> faces, Index wall, bool slides, State& state);

/// Young's modulus of Voronoi cells along an axis, sides free, over that of an endless network of the same bonds: next
/// to a plane face cells line up with it, so that few cells across are stiffer. Both as if all cells moved with one
/// strain: of that the ratio is true to some hundredths (docs/bonded.md). 1 where bonds have no modulus, or one length.
double stiffer_than_endless(const State& state, const BondModel& model, int axis);

/// A dead load (N) on faces, alike on every square metre, whole after a time `ramp` (s).
void add_load(std::span<const OuterFace> faces, const Vec3& force, double ramp, State& state);

}  // namespace grus::dem
