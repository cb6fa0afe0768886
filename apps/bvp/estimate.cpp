// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dem/base/error.hpp"
#include "dem/rve/measure.hpp"

namespace grus::app {
namespace {

constexpr double sweeps = 5;  // of an increment: Newton's usual four iterations, and its first answer

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

}  // namespace

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
  const dem::Vec3 part = still ? dem::Vec3(dem::Vec3::Zero()) : dem::Vec3(mean_strain(scene, stiffness) / steps);
  dem::Task task;
  task.path = {dem::Mat3(dem::Mat3::Identity() + dem::Mat3(part.asDiagonal()))};
  task.pace = scene.rve.pace;
  task.tangent = !scene.is_explicit();
  if (scene.dynamics) task.duration = scene.dynamics->duration / steps;
  dem::RveHost host(model, scene.rve.response, 1);
  host.put(0, {.state = state});
  const int tries = scene.is_explicit() ? static_cast<int>(std::min(50.0, steps)) : 1;
  const Clock clock;
  for (int k = 0; k < tries; ++k)
    if (const auto done = host.advance({task}); !done[0].response.stable)
      throw dem::Unstable("one RVE, taken through the first increment: " + done[0].response.failure);
  const double one = clock.wall() / tries, times = scene.is_explicit() ? steps : sweeps * steps;
  RunEstimate found;
  found.seconds = times * rounds_of(rves, workers) * one;
  found.text = scene.is_explicit()
                   ? fmt::format("{:.3g} steps, {} RVEs, {:.2g} ms a step of one", steps, rves, 1e3 * one)
                   : fmt::format("{} increments, {:.0f} sweeps each, {} RVEs at most, {:.3g} s an increment of one",
                                 scene.solve.increments, sweeps, rves, one);
  found.least = scene.is_explicit();
  found.rest = "more where grains break or increments are cut";
  if (scene.dynamics) found.rest = "the time step falls as RVEs stiffen, and grains that break take longer";
  if (scene.explicit_statics)
    found.rest = "the rate is lowered wherever its limits are met, and grains that break take longer";
  return found;
}

}  // namespace grus::app
