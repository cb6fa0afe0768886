// SPDX-License-Identifier: LGPL-3.0-or-later
// What stands at each Gauss point of a macro problem: an RVE of grains or an elastic solid.
#pragma once

#include "apps/scene/bvp_scene.hpp"
#include "coupling/rve_host.hpp"

namespace grus::app {

struct BvpPoints {
  std::vector<std::size_t> group;    // 0: grains; k: region k - 1
  std::vector<std::size_t> rve_of;   // number among the points with grains; SIZE_MAX: none
  std::vector<std::size_t> variant;  // of each point with grains
  std::vector<double> volume;        // m^3 of each point with grains
};

/// Of a problem on one rank. Throws InputError where grains are needed and the scene has none, or the other way round.
BvpPoints find_points(const BvpScene& scene, const fem::Problem& problem);

/// Void ratio, breakages a starting grain, and grains: of each cell three values, means over those of its points that have an RVE; NaN
/// where none has. `facts(k)`: of the k-th point with grains.
std::vector<double> cell_means(const std::vector<std::size_t>& rve_of, std::size_t points_per_cell,
                               const std::function<const coupling::Facts&(std::size_t)>& facts);

/// Prepared states of all variants that are in use, made by all ranks together; on rank 0, empty elsewhere and where unused.
/// Collective over MPI_COMM_WORLD. Throws, on all ranks or on rank 0, what the first variant that cannot be made throws: InputError, Unstable,
/// Interrupted where a rank's watch says so.
std::vector<dem::State> prepare_variants(const BvpScene& scene, const std::vector<std::size_t>& used, int threads, const dem::Watch& watch);

}  // namespace grus::app
