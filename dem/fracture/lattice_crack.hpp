// SPDX-License-Identifier: LGPL-3.0-or-later
// Does a grain hold what it bears, and if not, into what does it crack? Peridynamics on a lattice of points (Zhu and
// Zhao 2019; docs/physics/peridynamics.md). A function of shape, loads, parameters and (seed, id): no state is kept, so
// grains may be tested side by side and in any order.
#pragma once

#include <optional>

#include "dem/fracture/lattice.hpp"
#include "dem/fracture/peridynamic.hpp"

namespace grus::dem {

/// The model of one material, and when its tests stop.
struct LatticeModel {
  LatticeChoice lattice;
  double youngs_modulus = 0;  // Pa
  double poissons_ratio = 0.25;
  // Holds if no bond away from the patches is stretched by this share of the limit. 0: it is always asked further, for
  // five contacts may leave no such bond.
  double core_screen = 0;
  double damping = 3.2;          // of the crack run, times c_p / d
  double time = 2;               // it goes on after the grain has parted: passages of c_p through d
  double smallest_piece = 0.03;  // share of the points; smaller ones go to their neighbours,
  bool crumbs = false;           // or are told as crumbs
  // Bonds of points within the patches do not break: few points under a contact would be torn out, and the load with
  // them. False: as in the paper.
  bool keep_patches = true;
  bool tells_points = false;  // where they went is told, and a break carries them
};

enum class CrackVerdict {
  untested,    // no lattice fits it: too thin
  core_holds,  // by the static answer alone
  holds,
  cracks,
  stalled  // neither parts nor comes to rest; it is left whole
};

/// Points of a cracked grain.
struct CrackedLattice {
  std::vector<Vec3> points;    // from the mass centre, in the grain's frame (m)
  std::vector<int> piece;      // of each point, 0 to pieces - 1, the largest first, then crumbs
  std::vector<double> damage;  // share of each point's bonds that broke, by weight
  std::vector<Vec3> moved;     // displacements when the run ended, in the grain's frame (m); if told, as dilations
  std::vector<double> dilation;
  int pieces = 0, crumbs = 0;
  double spacing = 0;      // m
  double bond_energy = 0;  // that bonds gave up as they broke (J)
};

struct CrackResult {
  CrackVerdict verdict = CrackVerdict::untested;
  int points = 0;
  int solves = 0, iterations = 0;  // static answers, steps of conjugate gradients in all
  int rounds = 0;                  // of breaking bonds and solving again
  int steps = 0;                   // of the crack run
  double core_stretch = 0;         // largest away from the patches in the intact grain, share of the limit
  double load_factor = 1;          // share of the loads at which it cracked: those too large will have grown
  std::optional<CrackedLattice> cracked = {};
};

/// `stretch`: at which bonds break (critical_stretch). Throws InputError for a stretch or a modulus that is not above
/// 0.
CrackResult crack_test(const LatticeSolid& solid, std::span<const PatchLoad> loads, const LatticeModel& model,
                       double stretch, std::uint64_t seed, std::uint64_t id);

}  // namespace grus::dem
