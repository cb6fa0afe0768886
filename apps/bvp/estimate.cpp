// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dem/base/error.hpp"
#include "dem/rve/measure.hpp"

namespace grus::app {
namespace {

/// Sweeps of an increment: one where all stays linear, four where grains slide and break, as counted in the shipped
/// scenes (material_sweeps of summary.json).
constexpr double fewest_sweeps = 1, most_sweeps = 4;
constexpr std::size_t first_steps = 50;
constexpr double walk_time = 5;  // s, in which one RVE is taken along the whole path

/// What the RVEs must take: the largest displacement that a boundary prescribes over the mesh's length along it, or
/// the largest change of a load over the RVEs' stiffness.
dem::Vec3 mean_strain(const BvpScene& scene, const dem::Mat6& stiffness) {
  dem::Vec3 strain = dem::Vec3::Zero();
  for (const auto& b : scene.boundaries) {
    double least = b.history.at(0), most = least;
    for (const auto& point : b.history.points) least = std::min(least, point[1]), most = std::max(most, point[1]);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      const double length = scene.high[k] - scene.low[k],
                   load = (b.traction ? (*b.traction)[k] : 0) - b.pressure.value_or(0);
      double e = (most - least) * load / stiffness(axis, axis);
      if (length > 0 && b.displacement[k]) e = (most - least) * *b.displacement[k] / length;
      if (length > 0 && std::abs(e) > std::abs(strain[axis])) strain[axis] = e;
    }
  }
  return strain.cwiseMax(-0.5).cwiseMin(0.5);
}

/// Steps of a dynamic run, from the stable step of the mesh at its start.
double dynamic_steps(const BvpScene& scene, const BvpSetup& setup, const dem::Mat6& stiffness,
                     const dem::State& state) {
  const double of_grains = dem::total_mass(state.grains) / state.boundary.cell.volume();
  std::vector<double> density, tangent;
  for (const std::size_t group : setup.points.group) {
    if (group > 0) {
      const Region& r = scene.regions[group - 1];
      const auto solid = fem::elastic_stiffness(r.youngs_modulus, r.poissons_ratio);
      density.push_back(r.density), tangent.insert(tangent.end(), solid.begin(), solid.end());
    } else {
      density.push_back(of_grains), tangent.insert(tangent.end(), stiffness.data(), stiffness.data() + 36);
    }
  }
  return scene.dynamics->duration /
         fem::step_taken(*scene.dynamics, fem::stable_step(*setup.problem, density, tangent));
}

/// Wall time (s) of one RVE that is taken along the path in so many steps: all of them, or the rest like the last ones.
/// Of explicit runs the least: all steps like the first ones, or that, as most RVEs of a mesh are strained by less.
double walk(const BvpScene& scene, const std::shared_ptr<const dem::Model>& model, const dem::State& state,
            const dem::Task& task, double steps) {
  dem::RveHost host(model, scene.rve.response, 1);
  host.put(0, {.state = state});
  const Clock clock;
  std::vector<double> walls{0};  // after each step
  while (static_cast<double>(walls.size()) <= steps && clock.wall() < walk_time) {
    if (const auto done = host.advance({task}); !done[0].response.stable) {
      if (walls.size() > 1) break;  // grains of a whole mesh are not strained alike everywhere
      throw dem::Unstable("one RVE, taken through the first increment: " + done[0].response.failure);
    }
    if (!scene.is_explicit()) host.commit({0});
    walls.push_back(clock.wall());
  }
  const std::size_t count = walls.size() - 1, from = 3 * count / 4;
  const double last = (walls[count] - walls[from]) / static_cast<double>(count - from);
  const double whole = walls[count] + (steps - static_cast<double>(count)) * last;
  if (!scene.is_explicit()) return whole;
  const std::size_t first = std::min(count, first_steps);
  return std::min(whole, steps * walls[first] / static_cast<double>(first));
}

}  // namespace

dem::Task task_of(const BvpScene& scene, const dem::Vec3& strain, double steps) {
  dem::Task task;
  task.path = {dem::Mat3(dem::Mat3::Identity() + dem::Mat3((strain / steps).asDiagonal()))};
  task.pace = scene.rve.pace;
  task.tangent = !scene.is_explicit();
  if (scene.dynamics) task.duration = scene.dynamics->duration / steps;
  return task;
}

double rounds_of(std::size_t rves, int workers) { return std::ceil(static_cast<double>(rves) / workers); }

RunEstimate estimate_run(const BvpScene& scene, const BvpSetup& setup, const std::shared_ptr<const dem::Model>& model,
                         int workers) {
  const dem::State& state = setup.states[0];
  const std::size_t rves = setup.points.start.size();
  const dem::Mat6 stiffness = dem::contact_stiffness_tangent(*model, state);
  double steps = scene.solve.increments;
  if (scene.dynamics) steps = dynamic_steps(scene, setup, stiffness, state);
  if (const auto& e = scene.explicit_statics) steps = e->crossings * fem::crossing_steps(*setup.problem, *e);
  steps = std::max(1.0, std::ceil(steps));
  // RVEs in real time take as long whatever they strain by; what elastic regions leave them of it is not known.
  const bool still = scene.dynamics || (scene.explicit_statics && !scene.regions.empty());
  const dem::Vec3 strain = still ? dem::Vec3(dem::Vec3::Zero()) : mean_strain(scene, stiffness);
  const double one = walk(scene, model, state, task_of(scene, strain, steps), steps);
  RunEstimate found;
  const double all = rounds_of(rves, workers), told = one / steps;
  if (!scene.is_explicit()) {
    // Points that begin alike may be strained alike, and then one answers for all.
    const std::size_t starts = setup.points.starts.size();
    found.low = fewest_sweeps * rounds_of(starts, workers) * one, found.high = most_sweeps * all * one;
    found.text =
        fmt::format("{} increments, {:.0f} to {:.0f} sweeps each, {} RVEs of {} starts, {:.3g} s an increment of one",
                    scene.solve.increments, fewest_sweeps, most_sweeps, rves, starts, told);
    found.rest = "more where increments are cut";
    return found;
  }
  found.low = all * one;
  found.text = fmt::format("{:.3g} steps, {} RVEs, {:.2g} ms a step of one", steps, rves, 1e3 * told);
  if (scene.dynamics) found.rest = "the time step falls as RVEs stiffen, and grains that break take longer";
  if (scene.explicit_statics)
    found.rest =
        "2 to 3 times that where grains slide and break and the rate is lowered, 10 and more where a small part of the "
        "mesh takes the strain";
  return found;
}

}  // namespace grus::app
