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

/// How far forces are from balance in a step.
struct Balance {
  /// Unbalanced forces of nodes' free components, their number; forces applied at nodes, by loads and by what is
  /// prescribed, their number; inertial numbers, their number. Which nodes something is applied at is known from the
  /// facets: round-off makes a force behind a loaded one, too.
  std::array<double, 6> sums{};

  /// Mean unbalanced force over mean applied one, and the largest node's.
  double mean() const { return sums[1] > 0 ? over_applied(sums[0] / sums[1]) : over_applied(0); }
  double over_applied(double force) const {
    if (sums[2] == 0) return force > 0 ? INFINITY : 0;
    return force / (sums[2] / sums[3]);
  }
  double inertial_number() const { return sums[5] > 0 ? sums[4] / sums[5] : 0; }
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
    run.wishes = options.wishes;
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
      double &rho = wanted[static_cast<std::size_t>(c)], has = density[static_cast<std::size_t>(c)];
      const double a_unit = 4 * o.safety * o.safety / (1 + o.damping);  // 1/s^2 that a density of 1 makes stable
      rho = eigenvalue_above(has * a_unit, stiffness_over_mass(p, c, [](std::size_t) { return 1.0; })) *
            (1 + o.damping) / (4 * o.safety * o.safety);
      largest = std::max({largest, rho, has});
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

  /// Adds what Balance::sums are of this rank, and finds the largest node's unbalanced force of it.
  template <class Sums>
  void add_balance(double time, Sums& sums) {
    p.mark_applied(time, applied_at);
    const auto in = p.internal->array(), ex = p.external->array();
    run.most = 0;
    for (std::size_t n = 0; n < static_cast<std::size_t>(p.owned_nodes()); ++n) {
      double off2 = 0, applied2 = 0;
      bool free = false;
      for (std::size_t i = n * p.width(); i < (n + 1) * p.width(); ++i) {
        if (run.mass[n] == 0) continue;
        if (!run.fixed[i]) off2 += (ex[i] - in[i]) * (ex[i] - in[i]), free = true;
        const double applied = run.fixed[i] ? in[i] : ex[i];
        applied2 += applied * applied;
      }
      if (free) sums[0] += std::sqrt(off2), sums[1] += 1, run.most = std::max(run.most, std::sqrt(off2));
      if (applied_at[n] != 0 && run.mass[n] != 0) sums[2] += std::sqrt(applied2), sums[3] += 1;
    }
    if (p.discretisation.exact_sums)
      for (const double number : run.material.inertial_numbers()) sums[4] += number, sums[5] += 1;
  }

  /// Asked of all ranks at once. Where sums are exact the largest node's force is not: `respond` asks.
  Balance balance(double time) {
    Balance all{p.sums<6>([&](auto& sums) { add_balance(time, sums); })};
    if (p.discretisation.exact_sums) return all;
    MPI_Allreduce(MPI_IN_PLACE, &run.most, 1, MPI_DOUBLE, MPI_MAX, p.comm);
    all.sums[4] = mean_over_ranks(p.comm, run.material.inertial_number(), static_cast<double>(p.size()));
    all.sums[5] = 1;
    return all;
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
  if (!relax.run.respond(0, true, 0)) return false;
  p.commit();
  relax.scale_masses();
  relax.run.last_internal.assign(p.internal->array().begin(), p.internal->array().end());
  return true;
}

/// One step, in which the load factor goes on to `next`; with the balance where it is not `known`, for the governor.
void go_to(double next, double memory, const ExplicitStaticsOptions& o, Relaxation& relax, bool known, Balance& balance,
           ExplicitStaticsReport& now) {
  // Quasi-static motion goes with the load's rate: what departs from that is damped. Damped as a whole, it would be
  // held by every unbalanced force, and the loads would work against the damping.
  const double rate = next - now.load_factor;
  const Stride stride{1,
                      1,  // before the first, too: of a half one, f^2 dt^2 / 8 m of the start would be in no term
                      now.load_factor,
                      next,
                      o.damping,
                      now.steps == 0,
                      now.mean_rate > 0 ? std::min(1.0, rate / now.mean_rate) : 0.0,
                      rate > 0 ? memory : 0.0};
  if (known) {
    relax.run.step(stride, now.energy);
  } else {
    std::array<ExactSum, 6> mine{};
    relax.add_balance(now.load_factor, mine);
    balance.sums = relax.run.step(stride, now.energy, mine);
  }
  now.sums[0] += balance.mean(), now.sums[2] += balance.inertial_number();
  ++now.counted;
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
    if (!run.external_ready) p.assemble_external(now.load_factor);
    const bool waits = now.load_factor == 0, known = waits || !p.discretisation.exact_sums;
    Balance balance;
    if (known) balance = relax.balance(now.load_factor);
    // The load waits until what it starts with is in balance.
    const bool settled = !waits || balance.mean() <= o.balance;
    if (!settled && ++now.settling > settling) return failed(out_of_balance(now, balance.mean()));
    double next = now.load_factor;
    if (settled) next = std::min(easing.next(now.load_factor), next + now.rate * easing(next, now.rate));
    if (1 - next < 1e-12) next = 1;
    go_to(next, memory, o, relax, known, balance, now);
    const bool estimate = (now.steps + 1) % every == 0;
    if (!run.respond(0, estimate, next)) {
      p.back_to_committed();
      return failed("step " + std::to_string(now.steps + 1) + ": " + run.reason);
    }
    run.keep();
    now.sums[1] = std::max(now.sums[1], balance.over_applied(run.most));
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
