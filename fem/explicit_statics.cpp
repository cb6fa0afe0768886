// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/explicit_statics.hpp"

#include <algorithm>
#include <set>

#include "fem/central_differences.hpp"

namespace grus::fem {
namespace {

/// Stiffness below this share of the largest one there has been gets no mass of its own: what carries nothing must not
/// fly off.
constexpr double least_mass = 1e-3;

/// The load begins at this share of the rate's cap: hard grains have yielded at strains that a wave of the full rate
/// would carry at once. An interval makes the rate smaller or larger by so much at most.
constexpr double first_rate = 1.0 / 30, slowed = 0.5, hastened = 1.15;

/// Crossings of the mesh over which nodes' velocities are averaged: slow against its lowest mode, fast against bands.
constexpr double remembered = 5;

/// Between two bends of the loads the rate grows and falls as under a constant force, over two crossings of the mesh;
/// never below a twentieth.
class Easing {
public:
  Easing(const std::vector<BoundaryCondition>& boundaries, double steps) : steps_(steps) {
    std::set<double> all{0, 1};
    for (const auto& b : boundaries)
      for (const auto& p : b.history.points)
        if (p[0] > 0 && p[0] < 1) all.insert(p[0]);
    bends_.assign(all.begin(), all.end());
  }
  double operator()(double load_factor, double rate) const {
    double nearest = 1;
    for (const double b : bends_) nearest = std::min(nearest, std::abs(load_factor - b));
    return std::clamp(std::sqrt(2 * nearest / (rate * steps_)), 0.05, 1.0);
  }
  /// The next bend, which no step passes.
  double next(double load_factor) const { return *std::upper_bound(bends_.begin(), bends_.end() - 1, load_factor); }

private:
  std::vector<double> bends_;
  double steps_;
};

struct Relaxation {
  Problem::Impl& p;
  const ExplicitStaticsOptions& o;
  CentralDifferences run;
  std::vector<double>& density;          // of the elements, scaled (kg/m^3)
  std::vector<std::uint8_t> applied_at;  // owned nodes, now

  Relaxation(Problem::Impl& impl, Material& m, const ExplicitStaticsOptions& options)
      : p(impl), o(options), run(impl, m), density(impl.keep_of_cells("scaled density")) {
    run.drift = &impl.keep_at_nodes("drift");
  }

  /// Nodal masses by the elements' scaled densities.
  void weigh() {
    run.set_mass([&](std::int32_t c) {
      return cell_mass(p, c, [&](std::size_t) { return density[static_cast<std::size_t>(c)]; });
    });
  }

  /// Densities that give every element the step 1 / safety, where damping that holds against the motion adds to the
  /// restoring force: never lower than before, a softer element keeps its mass. Returns what the moving nodes gain (J).
  double scale_masses() {
    std::vector<double> wanted(static_cast<std::size_t>(p.cells));
    double largest = 0;
    for (std::int32_t c = 0; c < p.cells; ++c) {
      double& rho = wanted[static_cast<std::size_t>(c)];
      rho = largest_eigenvalue(p, c, [](std::size_t) { return 1.0; }) * (1 + o.damping) / (4 * o.safety * o.safety);
      largest = std::max({largest, rho, density[static_cast<std::size_t>(c)]});
    }
    double all = 0;
    MPI_Allreduce(&largest, &all, 1, MPI_DOUBLE, MPI_MAX, p.comm);
    for (std::size_t c = 0; c < wanted.size(); ++c) density[c] = std::max({density[c], wanted[c], least_mass * all});
    const std::vector<double> before = run.mass;
    weigh();
    return p.sums<1>([&](auto& gained) {
      for (std::size_t i = 0; i < static_cast<std::size_t>(p.owned_nodes()) * p.width() && !before.empty(); ++i)
        gained[0] += 0.5 * (run.mass[i / p.width()] - before[i / p.width()]) * run.velocity[i] * run.velocity[i];
    })[0];
  }

  /// Unbalanced forces of free components, mean and largest, over the mean force applied at nodes, by loads and by what
  /// is prescribed. Which nodes those are is known from the facets: round-off makes a force behind a loaded one, too.
  std::array<double, 2> unbalanced(double time) {
    p.mark_applied(time, applied_at);
    const auto in = p.internal->array(), ex = p.external->array();
    double most = 0, of_all = 0;
    const auto all = p.sums<4>([&](auto& sums) {  // unbalanced, nodes; applied, nodes
      for (std::size_t n = 0; n < static_cast<std::size_t>(p.owned_nodes()); ++n) {
        double off2 = 0, applied2 = 0;
        bool free = false;
        for (std::size_t i = n * p.width(); i < (n + 1) * p.width(); ++i) {
          if (run.mass[n] == 0) continue;
          if (!run.fixed[i]) off2 += (ex[i] - in[i]) * (ex[i] - in[i]), free = true;
          const double applied = run.fixed[i] ? in[i] : ex[i];
          applied2 += applied * applied;
        }
        if (free) sums[0] += std::sqrt(off2), sums[1] += 1, most = std::max(most, std::sqrt(off2));
        if (applied_at[n] != 0 && run.mass[n] != 0) sums[2] += std::sqrt(applied2), sums[3] += 1;
      }
    });
    MPI_Allreduce(&most, &of_all, 1, MPI_DOUBLE, MPI_MAX, p.comm);
    if (all[2] == 0) return {all[0] > 0 ? INFINITY : 0, of_all > 0 ? INFINITY : 0};
    const double scale = all[2] / all[3];
    return {all[1] > 0 ? all[0] / all[1] / scale : 0, of_all / scale};
  }
};

/// The rate for the next steps, by the worst of the limits.
void govern(const ExplicitStaticsOptions& o, double cap, ExplicitStaticsReport& now) {
  const double n = static_cast<double>(now.counted);
  now.unbalanced = now.sums[0] / n, now.inertial_number = now.sums[2] / n;
  now.largest_unbalanced = now.sums[1];
  now.sums = {}, now.counted = 0;
  const std::array<double, 3> used{now.unbalanced / o.balance,
                                   now.load_factor > 0.01 ? now.energy.kinetic_over_internal() / o.kinetic : 0.0,
                                   o.inertial_number > 0 ? now.inertial_number / o.inertial_number : 0.0};
  const auto worst = std::max_element(used.begin(), used.end());
  now.rate = std::min(cap, now.rate * std::clamp(std::pow(std::max(*worst, 1e-9), -0.3), slowed, hastened));
  now.governor = now.rate < cap ? static_cast<Governor>(1 + (worst - used.begin())) : Governor::none;
}

std::string out_of_balance(const ExplicitStaticsReport& now, double mean) {
  return "the loads at the start do not come into balance with the stress at the start: unbalanced force " +
         std::to_string(mean) + " of what is applied after " + std::to_string(now.steps) + " steps";
}

std::string cannot_hold(const ExplicitStaticsReport& now) {
  return "the balance cannot be held: unbalanced force " + std::to_string(now.unbalanced) +
         " of what is applied, kinetic energy " + std::to_string(now.energy.kinetic_over_internal()) +
         " of what the material holds, at a ten-thousandth of the usual rate";
}

}  // namespace

double crossing_steps(Problem& problem, const ExplicitStaticsOptions& o) {
  const Problem::Impl& p = problem.impl();
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {INFINITY, INFINITY, INFINITY};  // high: of -x
  for (const auto& x : p.node_at)
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], x[k]), high[k] = std::min(high[k], -x[k]);
  const double volume = p.sums<1>([&](auto& sum) {
    for (const auto& l : p.locals) sum[0] += l.dv / l.depth;  // area, in two dimensions
  })[0];
  MPI_Allreduce(MPI_IN_PLACE, low, 3, MPI_DOUBLE, MPI_MIN, p.comm);
  MPI_Allreduce(MPI_IN_PLACE, high, 3, MPI_DOUBLE, MPI_MIN, p.comm);
  double longest = 0;
  for (int k = 0; k < 3; ++k) longest = std::max(longest, -high[k] - low[k]);
  // A wave passes the same part of an element a step, whatever its size: elements along the longest side if all were
  // alike.
  const double cells = static_cast<double>(problem.global_points()) / static_cast<double>(problem.points_per_cell());
  const double size = std::pow(volume / cells, 1.0 / p.dim);
  return std::max(1.0, longest / size * p.discretisation.order) * std::sqrt(1 + o.damping) / o.safety;
}

namespace {

/// Forces of the start, and its masses. False: the materials have no answer.
bool begin(Relaxation& relax, Problem::Impl& p, bool resumed) {
  if (resumed) {
    relax.weigh();
    relax.run.go_on(1);
    return true;
  }
  if (!relax.run.respond(0, true)) return false;
  p.commit();
  relax.scale_masses();
  relax.run.last_internal.assign(p.internal->array().begin(), p.internal->array().end());
  return true;
}

double mean_inertial_number(const Problem::Impl& p, const Material& material) {
  if (!p.discretisation.exact_sums)
    return mean_over_ranks(p.comm, material.inertial_number(), static_cast<double>(p.size()));
  const auto all = p.sums<2>([&](auto& sums) {
    for (const double number : material.inertial_numbers()) sums[0] += number, sums[1] += 1;
  });
  return all[1] > 0 ? all[0] / all[1] : 0;
}

/// The unbalanced force's mean, note of its largest, and how hastily the RVEs are driven, for the governor.
double watch_balance(Relaxation& relax, const Material& material, ExplicitStaticsReport& now) {
  const auto [mean, largest] = relax.unbalanced(now.load_factor);
  now.sums[0] += mean;
  now.sums[1] = std::max(now.sums[1], largest);
  now.sums[2] += mean_inertial_number(relax.p, material);
  ++now.counted;
  return mean;
}

/// One step, in which the load factor goes on to `next`.
void go_to(double next, double memory, const ExplicitStaticsOptions& o, CentralDifferences& run,
           ExplicitStaticsReport& now) {
  // Quasi-static motion goes with the load's rate: what departs from that is damped. Damped as a whole, it would be
  // held by every unbalanced force, and the loads would work against the damping.
  const double rate = next - now.load_factor;
  run.step({1, now.steps > 0 ? 1.0 : 0.0, now.load_factor, next, o.damping, now.steps == 0,
            now.mean_rate > 0 ? std::min(1.0, rate / now.mean_rate) : 0.0, rate > 0 ? memory : 0.0},
           now.energy);
  if (rate > 0) now.mean_rate += (rate - now.mean_rate) / memory;
}

}  // namespace

ExplicitStaticsResult solve_explicit_statics(Problem& problem, Material& material, const ExplicitStaticsOptions& o,
                                             const std::function<bool(const ExplicitStaticsReport&)>& observer,
                                             const ExplicitStaticsReport& start) {
  Problem::Impl& p = problem.impl();
  ExplicitStaticsResult result;
  ExplicitStaticsReport& now = result.last;
  now = start;
  const auto failed = [&](std::string why) {
    result.failure = std::move(why);
    return result;
  };
  Relaxation relax(p, material, o);
  CentralDifferences& run = relax.run;
  const double crossing = crossing_steps(problem, o), cap = 1 / (o.crossings * crossing);
  const Easing easing(p.boundaries, 2 * crossing);
  const double memory = remembered * crossing;
  const auto settling = static_cast<std::uint64_t>(100 * crossing), rest = static_cast<std::uint64_t>(2 * crossing);
  if (!begin(relax, p, start.steps > 0)) return failed("the initial state: " + run.reason);
  if (start.steps == 0) now.rate = first_rate * cap;
  const auto next_report = [&] {
    return o.output_interval * (std::floor(now.load_factor / o.output_interval * (1 + 1e-12)) + 1);
  };
  double due = next_report();
  const auto every = static_cast<std::uint64_t>(o.estimate_every);
  while (now.load_factor < 1 || now.rested < rest) {
    p.assemble_external(now.load_factor);
    const double mean = watch_balance(relax, material, now);
    // The load waits until what it starts with is in balance.
    const bool settled = now.load_factor > 0 || mean <= o.balance;
    if (!settled && ++now.settling > settling) return failed(out_of_balance(now, mean));
    double next = now.load_factor;
    if (settled) next = std::min(easing.next(now.load_factor), next + now.rate * easing(next, now.rate));
    if (1 - next < 1e-12) next = 1;
    go_to(next, memory, o, run, now);
    const bool estimate = (now.steps + 1) % every == 0;
    if (!run.respond(0, estimate)) {
      p.back_to_committed();
      return failed("step " + std::to_string(now.steps + 1) + ": " + run.reason);
    }
    run.keep();
    now.energy.note_largest();
    if (now.load_factor == 1) ++now.rested;
    ++now.steps, now.load_factor = next;
    if (estimate) {
      now.energy.scaled += relax.scale_masses();
      govern(o, cap, now);
      if (now.rate < 1e-4 * cap) return failed(cannot_hold(now));
    }
    // Where little has been done yet, what the grains' start has cost is much of it.
    const bool told = now.load_factor > 0.02 && now.steps > 100;
    if (!std::isfinite(now.energy.kinetic) || (told && std::abs(now.energy.error()) > o.max_energy_error))
      return failed("energy error " + std::to_string(now.energy.error()) + " at step " + std::to_string(now.steps) +
                    ": the run has become unstable");
    const bool row = now.rested == rest || (now.load_factor < 1 && now.load_factor >= due * (1 - 1e-12));
    if (row) due = next_report();
    result.stopped = row ? !observer(now) : o.stop && o.stop();
    if (result.stopped) return result;
  }
  result.finished = true;
  return result;
}

}  // namespace grus::fem
