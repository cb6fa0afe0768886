// SPDX-License-Identifier: LGPL-3.0-or-later
// What stands at each Gauss point of a macro problem: an RVE of grains or an elastic solid.
#pragma once

#include "apps/scene/bvp_scene.hpp"
#include "dem/rves/rve_host.hpp"

namespace grus::app {

/// What a cell starts from: a packing, as prepared or brought to a stress.
struct Start {
  std::size_t packing = 0;
  bool stressed = false;
  fem::Point stress{};  // along x, y, z (Pa, compression-positive)
  auto operator<=>(const Start&) const = default;
};

struct BvpPoints {
  std::vector<std::size_t> group;   // 0: grains; k: region k - 1
  std::vector<std::size_t> rve_of;  // number among the points with grains; SIZE_MAX: none
  std::vector<std::size_t> start;   // of each point with grains: which of the starts
  std::vector<Start> starts;
  std::vector<double> volume;  // m^3 of each point with grains
};

/// Of a problem on one rank; `density`: bulk density of the cells (kg/m^3), for the stress of the ground. Throws
/// InputError where grains are needed and the scene has none, or the other way round.
BvpPoints find_points(const BvpScene& scene, const fem::Problem& problem, double density = 0);

/// Void ratio, breakages a starting grain, and grains: of each cell three values, means over those of its points that
/// have an RVE; NaN where none has. `facts(k)`: of the k-th point with grains.
std::vector<double> cell_means(const std::vector<std::size_t>& rve_of, std::size_t points_per_cell,
                               const std::function<const dem::Facts&(std::size_t)>& facts);

/// Prepared states, made by all ranks together; on rank 0, empty elsewhere.
/// Collective over MPI_COMM_WORLD. Throws, on all ranks or on rank 0, what the first one that cannot be made throws:
/// InputError, Unstable, Interrupted where a rank's watch says so.
std::vector<dem::State> prepare_starts(const BvpScene& scene, const std::vector<Start>& starts, int threads,
                                       const dem::Watch& watch);

/// Stress of the ground at rest (Pa, Voigt) at a point, whose material has this bulk density (kg/m^3).
std::array<double, 6> ground_stress(const BvpScene& scene, const fem::Point& at, double density);

}  // namespace grus::app
