// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/dynamics.hpp"

#include <algorithm>

#include "fem/problem_impl.hpp"

namespace grus::fem {
namespace {

using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Lumped mass of a cell's nodes: diagonal of the consistent mass, scaled to the cell's mass (Hinton, Rock, Zienkiewicz).
Eigen::VectorXd cell_mass(const Problem::Impl& p, const std::vector<double>& density, std::int32_t c) {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(p.nodes);
  double mass = 0;
  Problem::Impl::Local l;
  for (int q = 0; q < p.nq; ++q) {
    p.local(c, q, l);
    const double dm = density[p.point(c, q)] * l.dv;
    mass += dm;
    diagonal.array() += dm * l.value.array().square();
  }
  return diagonal * (mass / diagonal.sum());
}

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

struct Integrator {
  Problem::Impl& p;
  Material& material;
  const std::vector<double>& density;
  const DynamicsOptions& o;
  std::vector<double> mass, lengths, viscous, volumes;  // owned and ghost components; cells; points (Pa); points (m^3)
  std::vector<std::int8_t> fixed;              // components
  std::vector<double> moved;                   // components, by the last step (m)
  double dissipated = 0;                       // by bulk viscosity in the last step (J)
  std::string reason;

  Integrator(Problem::Impl& impl, Material& m, const std::vector<double>& rho, const DynamicsOptions& options) : p(impl), material(m), density(rho), o(options) {
    Problem::Impl::Vector sum(p.space->dofmap()->index_map, 1);
    sum.set(0.0);
    auto values = sum.mutable_array();
    Problem::Impl::Local l;
    for (std::int32_t c = 0; c < p.cells; ++c) {
      const Eigen::VectorXd part = cell_mass(p, density, c);
      for (int a = 0; a < p.nodes; ++a) values[static_cast<std::size_t>(p.cell_nodes(c)[static_cast<std::size_t>(a)])] += part[a];
      lengths.push_back(cell_length(p, c));
      for (int q = 0; q < p.nq; ++q) p.local(c, q, l), volumes.push_back(l.dv);
    }
    sum.scatter_rev(std::plus<double>());
    sum.scatter_fwd();
    mass.assign(sum.array().begin(), sum.array().end());
    viscous.assign(p.size(), 0);
    fixed.assign(p.u->array().size(), 0);
    for (const auto& c : p.prescribed) fixed[static_cast<std::size_t>(c.dof)] = 1;
    moved.assign(fixed.size(), 0);
  }

  /// Stress of the step just moved through, bulk viscosity included in the forces only.
  bool respond(double dt, bool want_tangent) {
    p.u->scatter_fwd();
    if (!p.strain_sweep()) return reason = "an element turned inside out", false;
    const bool mine = material.respond({p.deformation, p.stress, want_tangent ? std::span<double>(p.tangent) : std::span<double>(), dt});
    if (!all_true(p.comm, mine)) return reason = mine ? "a Gauss point of another rank failed" : material.reason(), false;
    material.commit();
    if (o.linear_viscosity > 0 || o.quadratic_viscosity > 0) add_viscosity(dt);
    p.assemble_internal();
    for (std::size_t i = 0; i < viscous.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) p.stress[6 * i + k] += viscous[i];
    return true;
  }

  void add_viscosity(double dt) {
    for (std::int32_t c = 0; c < p.cells; ++c)
      for (int q = 0; q < p.nq; ++q) {
        const std::size_t i = p.point(c, q);
        const double* f = p.deformation.data() + 9 * i;
        const double rate = dt > 0 ? (f[0] + f[4] + f[8] - 3) / dt : 0, rho = density[i], h = lengths[static_cast<std::size_t>(c)];
        viscous[i] = 0;
        if (rate >= 0) continue;
        const double wave = std::sqrt(std::max({p.tangent[36 * i], p.tangent[36 * i + 7], p.tangent[36 * i + 14], 0.0}) / rho);
        viscous[i] = rho * h * (o.linear_viscosity * wave * -rate + o.quadratic_viscosity * o.quadratic_viscosity * h * rate * rate);
        dissipated += viscous[i] * -rate * dt * volumes[i] * Eigen::Map<const RowMatrix3>(p.F.data() + 9 * i).determinant();
        for (std::size_t k = 0; k < 3; ++k) p.stress[6 * i + k] -= viscous[i];
      }
  }
};

}  // namespace

double MacroEnergy::error() const {
  const double scale = std::max({largest, std::abs(external), kinetic, std::abs(internal), viscous});
  return scale > 0 ? (external - kinetic - internal - viscous) / scale : 0;
}

void allocate_dynamics(Problem& problem) {
  Problem::Impl& p = problem.impl();
  for (auto* nodal : {&p.velocity, &p.last_load, &p.last_internal, &p.now_internal}) nodal->assign(p.u->array().size(), 0.0);
}

double stable_step(Problem& problem, const std::vector<double>& density) {
  const Problem::Impl& p = problem.impl();
  double largest = 0, all = 0;
  Problem::Impl::Matrix k;
  for (std::int32_t c = 0; c < p.cells; ++c) {
    p.cell_tangent(c, k);
    const Eigen::VectorXd m = cell_mass(p, density, c);
    for (int a = 0; a < k.rows(); ++a)
      for (int b = 0; b < k.cols(); ++b) k(a, b) /= std::sqrt(m[a / p.components] * m[b / p.components]);
    const Eigen::MatrixXd symmetric = 0.5 * (k + k.transpose());
    largest = std::max(largest, Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff());
  }
  MPI_Allreduce(&largest, &all, 1, MPI_DOUBLE, MPI_MAX, p.comm);
  return all > 0 ? 2 / std::sqrt(all) : INFINITY;
}

DynamicsResult solve_dynamics(Problem& problem, Material& material, const std::vector<double>& density, const DynamicsOptions& o,
                              const std::function<bool(const DynamicsReport&)>& observer, const DynamicsReport& start) {
  Problem::Impl& p = problem.impl();
  DynamicsResult result;
  DynamicsReport& now = result.last;
  now = start;
  Integrator run(p, material, density, o);
  if (p.velocity.empty()) allocate_dynamics(problem);
  if (start.steps == 0) {
    if (!run.respond(0, true)) return result.failure = "the initial state: " + run.reason, result;
    p.commit();
  } else {
    std::copy(p.now_internal.begin(), p.now_internal.end(), p.internal->mutable_array().begin());
    for (std::size_t i = 0; i < run.moved.size(); ++i) run.moved[i] = start.dt * p.velocity[i];
    run.dissipated = start.dissipated;
  }
  const double xi = o.linear_viscosity, slower = std::sqrt(1 + xi * xi) - xi;
  auto next_report = [&] { return o.output_interval > 0 ? o.output_interval * (std::floor(now.time / o.output_interval * (1 + 1e-12)) + 1) : o.duration; };
  double due = next_report();
  if (start.steps == 0) p.last_internal.assign(p.internal->array().begin(), p.internal->array().end());
  const auto owned = p.width() * static_cast<std::size_t>(p.owned_nodes());
  MacroEnergy total = start.energy;
  double last_dt = start.dt, stable = start.steps > 0 ? start.dt : 0;
  std::uint64_t estimate = (start.steps + static_cast<std::uint64_t>(o.estimate_every) - 1) / static_cast<std::uint64_t>(o.estimate_every) * static_cast<std::uint64_t>(o.estimate_every);
  while (now.time < o.duration * (1 - 1e-12)) {
    if (now.steps >= estimate) {
      stable = o.time_step > 0 ? o.time_step : o.safety * slower * stable_step(problem, density);
      if (!std::isfinite(stable)) return result.failure = "no element has a stiffness, so there is no stable step; give solve.time_step", result;
      estimate += static_cast<std::uint64_t>(o.estimate_every);
    }
    const double dt = std::min(stable, o.duration - now.time), mean_dt = now.steps == 0 ? 0.5 * dt : 0.5 * (last_dt + dt);
    p.assemble_external(now.time);
    const auto in = p.internal->array(), ex = p.external->array();
    std::vector<double>& v = p.velocity;
    auto target = [&](const Prescribed& c) { return (p.factor(c.boundary, now.time + dt) - p.factor(c.boundary, now.time)) * c.value / dt; };
    // All is told of the instant of the positions: work by the forces at the ends of the last step, velocities between its two.
    double sums[5] = {0, 0, 0, 0, 0}, all[5];  // external, kinetic, work of the internal forces, viscous, internal
    const double part = mean_dt > 0 ? 0.5 * last_dt / mean_dt : 0;
    if (now.steps == 0)  // driven nodes start with the speed they are given
      for (const auto& c : p.prescribed)
        if (const auto i = static_cast<std::size_t>(c.dof); i < owned) v[i] = target(c), sums[0] += 0.5 * run.mass[i / p.width()] * v[i] * v[i];
    std::vector<double>&load = p.last_load, &before = p.last_internal;
    auto turn = [&](std::size_t i, double next, double force) {
      sums[0] += 0.5 * (load[i] + force) * run.moved[i];
      const double at_instant = v[i] + part * (next - v[i]);
      sums[1] += 0.5 * run.mass[i / p.width()] * at_instant * at_instant;
      sums[2] += 0.5 * (before[i] + in[i]) * run.moved[i];
      load[i] = force, before[i] = in[i];
      v[i] = next;
      run.moved[i] = dt * next;
    };
    for (std::size_t i = 0; i < owned; ++i)
      if (!run.fixed[i]) turn(i, v[i] + mean_dt * (ex[i] - in[i]) / run.mass[i / p.width()], ex[i]);
    for (const auto& c : p.prescribed)
      if (const auto i = static_cast<std::size_t>(c.dof); i < owned) {
        const double next = target(c);
        turn(i, next, in[i] + run.mass[i / p.width()] * (next - v[i]) / mean_dt);
      }
    auto u = p.u->mutable_array();
    for (std::size_t i = 0; i < owned; ++i) u[i] += run.moved[i];
    const bool tangent = now.steps + 1 >= estimate;
    sums[2] -= run.dissipated, sums[3] = run.dissipated, sums[4] = material.energy(run.volumes);
    MPI_Allreduce(sums, all, 5, MPI_DOUBLE, MPI_SUM, p.comm);
    total.external += all[0], total.kinetic = all[1], total.work += all[2], total.viscous += all[3], total.internal = all[4];
    run.dissipated = 0;
    if (!run.respond(dt, tangent)) {
      p.back_to_committed();
      result.failure = "step " + std::to_string(now.steps + 1) + ": " + run.reason;
      return result;
    }
    p.commit();
    p.now_internal.assign(p.internal->array().begin(), p.internal->array().end());
    last_dt = dt;
    total.largest = std::max({total.largest, std::abs(total.external), total.kinetic, std::abs(total.internal), total.viscous});
    now.time += dt, now.dt = dt, ++now.steps, now.energy = total, now.dissipated = run.dissipated;
    // The first steps start from rest, and a pulse that sets in smoothly is not resolved by its first few: what nothing drives tells
    // itself by then.
    const double early = now.steps > 10 ? 0.5 : INFINITY, allowed = now.steps > 100 ? o.max_energy_error : std::max(o.max_energy_error, early);
    if (!std::isfinite(total.kinetic) || std::abs(total.error()) > allowed) {
      result.failure = "energy error " + std::to_string(total.error()) + " at step " + std::to_string(now.steps) + ": the run has become unstable";
      return result;
    }
    if (now.time >= due * (1 - 1e-12) || now.time >= o.duration * (1 - 1e-12)) {
      due = next_report();
      if (!observer(now)) return result.stopped = true, result;
    } else if (o.stop && o.stop()) {
      return result.stopped = true, result;
    }
  }
  result.finished = true;
  return result;
}

}  // namespace grus::fem
