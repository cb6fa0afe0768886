// SPDX-License-Identifier: LGPL-3.0-or-later
// The Gauss points of a macro problem: an RVE of grains stands at each, or an elastic solid.
#pragma once

#include "apps/bvp/scene/bvp_scene.hpp"
#include "dem/rves/rve_host.hpp"

namespace grus::app {

/// The start of an RVE: a packing, as prepared or brought to a stress.
struct Start {
  std::size_t packing = 0;
  bool stressed = false;
  fem::Point stress{};  // along x, y, z (Pa, compression-positive)
  auto operator<=>(const Start&) const = default;
};

/// Starts of one packing whose stresses are alike: one state is prepared for them, at the stress in their middle.
struct StressClass {
  Start start;
  std::size_t members = 1;
  double deviation = 0;  // largest of a member's stress from it, relative to the member's
};

/// Classes of sorted starts, of which no member deviates by more than the tolerance; those of one depth line are in
/// proportion.
/// Where a class has one member it is that, bit by bit.
std::vector<StressClass> stress_classes(const std::vector<Start>& starts, double tolerance);

struct BvpPoints {
  std::vector<std::size_t> group;   // 0: grains; k: region k - 1
  std::vector<std::size_t> rve_of;  // number among the points with grains; SIZE_MAX: none
  std::vector<std::size_t> start;   // of each point with grains: which of the starts
  std::vector<Start> starts;        // of the classes of stress
  std::size_t stresses = 0;         // how many there were before; of each packing
  double deviation = 0;             // largest of a point's stress from its start's, relative
  std::vector<double> volume;       // m^3 of each point with grains
  std::uint64_t all_rves = 0;       // points with grains, over all ranks
};

/// The points that a problem has on this rank, with the starts of all ranks' points; `density`: bulk density of the
/// RVEs (kg/m^3), for the stress of the ground. Throws InputError where grains are needed and the scene has none, or
/// the other way round.
BvpPoints find_points(const BvpScene& scene, const fem::Problem& problem, double density = 0);

/// The rank that each element of the mesh goes to, so that all ranks have RVEs of equal number, and what lies near lies
/// together; of equal cost, where it has been `measured`: of each element (s a step), on rank 0. The same on all ranks
/// of the problem, which must all ask.
std::vector<std::int32_t> equal_parts(const fem::Problem& problem, const BvpPoints& points,
                                      const std::vector<double>& measured);

/// Void ratio, breakages a starting grain, and grains: of each element three values, means over those of its points
/// that have an RVE; NaN where none has. `facts(k)`: of the k-th point with grains.
std::vector<double> element_means(const std::vector<std::size_t>& rve_of, std::size_t points_per_cell,
                                  const std::function<const dem::Facts&(std::size_t)>& facts);

/// Stress of the ground at rest (Pa, Voigt) at a point, whose material has this bulk density (kg/m^3).
std::array<double, 6> ground_stress(const BvpScene& scene, const fem::Point& at, double density);

}  // namespace grus::app
