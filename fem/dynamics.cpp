// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/dynamics.hpp"

#include <algorithm>

#include "fem/central_differences.hpp"

namespace grus::fem {
namespace {

using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Shortest distance between corners.
double cell_length(const Problem::Impl& p, std::int32_t c) {
  const auto nodes = compat::geometry_dofs(*p.mesh, c);
  const auto x = p.mesh->geometry().x();
  double shortest = INFINITY;
  auto corner = [&](std::size_t a) { return Eigen::Map<const Eigen::Vector3d>(x.data() + 3 * nodes[a]); };
  for (std::size_t a = 0; a < nodes.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) shortest = std::min(shortest, (corner(a) - corner(b)).norm());
  return shortest;
}

/// Central differences with bulk viscosity, which is in the forces only.
struct Integrator {
  Problem::Impl& p;
  const std::vector<double>& density;
  const DynamicsOptions& o;
  CentralDifferences run;
  std::vector<double> lengths, viscous;  // of elements (m); of points (Pa)

  Integrator(Problem::Impl& impl, Material& m, const std::vector<double>& rho, const DynamicsOptions& options)
      : p(impl), density(rho), o(options), run(impl, m), viscous(impl.size(), 0) {
    run.set_mass([&](std::int32_t c) { return cell_mass(p, c, [&](std::size_t i) { return density[i]; }); });
    for (std::int32_t c = 0; c < p.cells; ++c) lengths.push_back(cell_length(p, c));
  }

  bool respond(double dt, bool want_tangent, double next) {
    const bool bulk = o.linear_viscosity > 0 || o.quadratic_viscosity > 0;
    if (!run.respond(dt, want_tangent, next, [&] {
          if (bulk) add_viscosity(dt);
        }))
      return false;
    for (std::size_t i = 0; i < viscous.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) p.stress[6 * i + k] += viscous[i];
    return true;
  }

  void add_viscosity(double dt) {
    run.viscous += p.sums<1>([&](auto& sum) { add_viscosity(dt, sum[0]); })[0];
  }

  template <class Sum>
  void add_viscosity(double dt, Sum& taken) {
    for (std::int32_t c = 0; c < p.cells; ++c)
      for (int q = 0; q < p.nq; ++q) {
        const std::size_t i = p.point(c, q);
        const double* f = p.deformation.data() + 9 * i;
        const double rate = dt > 0 ? (f[0] + f[4] + f[8] - 3) / dt : 0, rho = density[i],
                     h = lengths[static_cast<std::size_t>(c)];
        viscous[i] = 0;
        if (rate >= 0) continue;
        const double wave =
            std::sqrt(std::max({p.tangent[36 * i], p.tangent[36 * i + 7], p.tangent[36 * i + 14], 0.0}) / rho);
        viscous[i] =
            rho * h *
            (o.linear_viscosity * wave * -rate + o.quadratic_viscosity * o.quadratic_viscosity * h * rate * rate);
        taken +=
            viscous[i] * -rate * dt * run.volumes[i] * Eigen::Map<const RowMatrix3>(p.F.data() + 9 * i).determinant();
        for (std::size_t k = 0; k < 3; ++k) p.stress[6 * i + k] -= viscous[i];
      }
  }
};

}  // namespace

double stable_step(Problem& problem, const std::vector<double>& density) {
  const Problem::Impl& p = problem.impl();
  double largest = 0, all = 0;
  for (std::int32_t c = 0; c < p.cells; ++c)
    largest = std::max(largest,
                       eigenvalue_above(largest, stiffness_over_mass(p, c, [&](std::size_t i) { return density[i]; })));
  MPI_Allreduce(&largest, &all, 1, MPI_DOUBLE, MPI_MAX, p.comm);
  return all > 0 ? 2 / std::sqrt(all) : INFINITY;
}

double stable_step(Problem& problem, const std::vector<double>& density, const std::vector<double>& tangent) {
  problem.impl().tangent = tangent;
  return stable_step(problem, density);
}

double step_taken(const DynamicsOptions& o, double stable) {
  const double xi = o.linear_viscosity, slower = std::sqrt(1 + xi * xi) - xi;
  return o.time_step > 0 ? o.time_step : o.safety * slower * stable;
}

namespace {

/// Forces of the start. False: the material has no answer.
bool begin(Integrator& run, Problem::Impl& p, const DynamicsReport& start) {
  if (start.steps > 0) {
    run.run.go_on(start.dt);
    run.run.viscous = start.dissipated;
    return true;
  }
  if (!run.respond(0, true, 0)) return false;
  p.commit();
  run.run.last_internal.assign(p.internal->array().begin(), p.internal->array().end());
  return true;
}

double allowed_error(const DynamicsOptions& o, std::uint64_t steps) {
  // The first steps start from rest, and a pulse that sets in smoothly is not resolved by its first few: what nothing
  // drives tells itself by then.
  if (steps > 100) return o.max_energy_error;
  return std::max(o.max_energy_error, steps > 10 ? 0.5 : INFINITY);
}

}  // namespace

DynamicsResult solve_dynamics(Problem& problem, Material& material, const std::vector<double>& density,
                              const DynamicsOptions& o, const std::function<bool(const DynamicsReport&)>& observer,
                              const DynamicsReport& start) {
  Problem::Impl& p = problem.impl();
  DynamicsResult result;
  DynamicsReport& now = result.last;
  now = start;
  const auto failed = [&](std::string why) {
    result.failure = std::move(why);
    return result;
  };
  Integrator run(p, material, density, o);
  run.run.wishes = o.wishes;
  if (!begin(run, p, start)) return failed("the initial state: " + run.run.reason);
  auto next_report = [&] {
    return o.output_interval > 0 ? o.output_interval * (std::floor(now.time / o.output_interval * (1 + 1e-12)) + 1)
                                 : o.duration;
  };
  double due = next_report();
  MacroEnergy total = start.energy;
  double last_dt = start.dt, stable = start.steps > 0 ? start.dt : 0;
  std::uint64_t estimate = (start.steps + static_cast<std::uint64_t>(o.estimate_every) - 1) /
                           static_cast<std::uint64_t>(o.estimate_every) * static_cast<std::uint64_t>(o.estimate_every);
  while (now.time < o.duration * (1 - 1e-12)) {
    if (now.steps >= estimate) {
      stable = step_taken(o, o.time_step > 0 ? 0 : stable_step(problem, density));
      if (!std::isfinite(stable))
        return failed("no element has a stiffness, so there is no stable step; give solve.time_step");
      estimate += static_cast<std::uint64_t>(o.estimate_every);
    }
    const double dt = std::min(stable, o.duration - now.time);
    if (!run.run.external_ready) p.assemble_external(now.time);
    run.run.step({dt, last_dt, now.time, now.time + dt, 0, now.steps == 0}, total);
    const bool tangent = now.steps + 1 >= estimate;
    if (!run.respond(dt, tangent, now.time + dt)) {
      p.back_to_committed();
      return failed("step " + std::to_string(now.steps + 1) + ": " + run.run.reason);
    }
    run.run.keep();
    last_dt = dt;
    total.note_largest();
    now.time += dt;
    now.dt = dt;
    ++now.steps;
    now.energy = total;
    now.dissipated = run.run.viscous;
    if (!std::isfinite(total.kinetic) || std::abs(total.error()) > allowed_error(o, now.steps))
      return failed("energy error " + std::to_string(total.error()) + " at step " + std::to_string(now.steps) +
                    ": the run has become unstable");
    const bool row = now.time >= due * (1 - 1e-12) || now.time >= o.duration * (1 - 1e-12);
    if (row) due = next_report();
    result.stopped = row ? !observer(now) : o.stop && o.stop();
    if (result.stopped) return result;
  }
  result.finished = true;
  return result;
}

}  // namespace grus::fem
