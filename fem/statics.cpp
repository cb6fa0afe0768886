// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/statics.hpp"

#include <algorithm>

#include "fem/acceleration.hpp"
#include "fem/linear_solver.hpp"
#include "fem/material_energy.hpp"

namespace grus::fem {
namespace {

struct Newton {
  Problem::Impl& p;
  Material& material;
  const StaticsOptions& o;
  LinearSolver linear;
  std::vector<std::uint8_t> fixed;  // owned components
  int sweeps = 0;
  std::string reason;
  static constexpr double forgotten = 0.02, softest = 1e-3, still = 1e-7;
  double force = 0, largest_force = 0;  // norm of all forces (N): now, and the largest committed so far
  double stiffest = 0;                  // mean tangent (Pa): the largest committed so far
  double last_size = 0;                 // of the load factor, in the last increment; 0: nothing to go by
  MacroEnergy energy;                   // since the start
  std::vector<double> volumes;          // of points (m^3)
  std::vector<double> energies;         // of points (J), with exact sums
  std::vector<double>& previous_u;      // committed before the last increment (m), owned and ghost components
  std::vector<double> last_outside;  // forces from outside when the last increment was accepted (N), owned components

  Newton(Problem::Impl& problem, Material& m, const StaticsOptions& options)
      : p(problem),
        material(m),
        o(options),
        linear(problem, options.linear),
        previous_u(p.keep_at_nodes("previous u")) {
    need_energies(p, material);
    fixed.assign(p.width() * static_cast<std::size_t>(p.owned_nodes()), 0);
    for (const auto& c : p.prescribed)
      if (static_cast<std::size_t>(c.dof) < fixed.size()) fixed[static_cast<std::size_t>(c.dof)] = 1;
    for (const auto& l : p.locals) volumes.push_back(l.dv);
  }

  /// Strain and material sweeps at the present displacement, then forces at a time. All ranks agree on the outcome.
  bool evaluate(double time) {
    p.u->scatter_fwd();
    ++sweeps;
    if (!p.strain_sweep()) {
      reason = "an element turned inside out";
      return false;
    }
    const bool mine = material.respond({p.deformation, p.stress, p.tangent});
    if (!all_true(p.comm, mine)) {
      reason = material.reason();
      if (reason.empty()) reason = "a Gauss point of another rank refused the increment";
      return false;
    }
    hold_loose_points();
    p.assemble_internal();
    p.assemble_external(time);
    return true;
  }

  /// Points that carry nothing any more get a thousandth of the stiffest tangent, in the tangent that makes the matrix,
  /// not in the stress; it is committed with the point as the predictor's tangent: their nodes would be nowhere
  /// otherwise. Stress is not touched, so what converges is the same.
  void hold_loose_points() {
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double missing = softest * stiffest - mean_tangent(i);
      for (std::size_t k = 0; k < 6 && missing > 0; ++k) p.tangent[36 * i + 7 * k] += missing;
    }
  }

  /// Mean of the diagonal of point i's tangent (Pa).
  double mean_tangent(std::size_t i) const {
    double trace = 0;
    for (std::size_t k = 0; k < 6; ++k) trace += p.tangent[36 * i + 7 * k];
    return trace / 6;
  }

  /// external - internal on owned components; relative norm over the free ones.
  double residual(std::vector<double>& r) {
    const auto in = p.internal->array(), ex = p.external->array();
    r.resize(fixed.size());
    auto [free, scale] = p.sums<2>([&](auto& sum) {
      for (std::size_t i = 0; i < r.size(); ++i) {
        r[i] = ex[i] - in[i];
        if (!fixed[i]) sum[0] += r[i] * r[i];
        sum[1] += in[i] * in[i] + ex[i] * ex[i];
      }
    });
    force = std::sqrt(scale);
    // Where nearly all is gone of the largest forces there were, what is left need not balance better than a share of
    // those.
    scale = std::max(force, forgotten * largest_force);
    return scale > 0 ? std::sqrt(free) / scale : 0;
  }

  void move(const std::vector<double>& dx, double part) {
    auto u = p.u->mutable_array();
    for (std::size_t i = 0; i < dx.size(); ++i) u[i] += part * dx[i];
  }

  double largest(const std::vector<double>& v) const {
    double mine = 0;
    for (double x : v) mine = std::max(mine, std::abs(x));
    return largest_of_ranks(mine);
  }

  /// Largest displacement component so far (m).
  double farthest() const {
    double mine = 0;
    for (std::size_t i = 0; i < fixed.size(); ++i) mine = std::max(mine, std::abs(p.u->array()[i]));
    return largest_of_ranks(mine);
  }

  double largest_of_ranks(double mine) const {
    double all = 0;
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_MAX, p.comm);
    return all;
  }

  void commit() {
    material.commit();
    p.commit();
    largest_force = std::max(largest_force, force);
    double mine = 0;
    for (std::size_t i = 0; i < p.size(); ++i) mine = std::max(mine, mean_tangent(i));
    stiffest = std::max(stiffest, largest_of_ranks(mine));
  }

  /// True where loads and prescribed displacements go on as in the last increment: none starts, ends or turns.
  bool goes_on(double from, double to) const {
    if (last_size == 0) return false;
    for (std::size_t b = 0; b < p.boundaries.size(); ++b) {
      const double then = (p.factor(b, from) - p.factor(b, from - last_size)) / last_size;
      const double now = (p.factor(b, to) - p.factor(b, from)) / (to - from);
      if (std::abs(now - then) > 1e-9 * std::max(std::abs(now), std::abs(then))) return false;
    }
    return true;
  }

  /// A better tangent on any rank is one for all.
  bool sharpen() const { return largest_of_ranks(material.sharpen() ? 1 : 0) > 0; }

  void go_on(const StaticsStart& start) {
    sweeps = start.law_sweeps;
    largest_force = start.largest_force;
    stiffest = start.stiffest;
    last_size = start.last_size;
    energy = start.energy;
  }

  /// What another run needs to go on from here.
  void tell(IncrementReport& report) {
    report.law_sweeps = sweeps;
    report.largest_force = largest_force;
    report.stiffest = stiffest;
    report.last_size = last_size;
    report.energy = energy;
    report.linear_iterations = linear.iterations(), report.linear_failures = linear.failures();
  }

  /// The last increment's displacements, for a load increment of this size: nearer to what yields than any tangent.
  std::vector<double> as_before(double size) const {
    std::vector<double> dx(fixed.size());
    for (std::size_t i = 0; i < dx.size(); ++i)
      dx[i] = (p.committed_u->array()[i] - previous_u[i]) * (size / last_size);
    return dx;
  }

  /// Forces from outside: loads where a component is free, what holds it where it is prescribed.
  std::vector<double> outside() const {
    const auto in = p.internal->array(), ex = p.external->array();
    std::vector<double> all(fixed.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = fixed[i] ? in[i] : ex[i];
    return all;
  }

  void accept(double size) {
    const std::vector<double> now = outside();
    const auto u = p.u->array(), before = p.committed_u->array();
    energy.external += p.sums<1>([&](auto& done) {
      for (std::size_t i = 0; i < now.size(); ++i) done[0] += 0.5 * (last_outside[i] + now[i]) * (u[i] - before[i]);
    })[0];
    last_outside = now;
    energy.work += p.work_since_commit();
    previous_u.assign(p.committed_u->array().begin(), p.committed_u->array().end());
    last_size = size;
    commit();
    energy.internal = p.sums<1>([&](auto& sum) { add_energy(material, volumes, energies, sum[0]); })[0];
    energy.note_largest();
  }

  /// Where increments begin: from the start, with the forces that its stress is in balance with.
  void begin(bool resumed, double time) {
    if (resumed) {
      p.back_to_committed();
      p.assemble_external(time);
      last_outside = outside();
      return;
    }
    std::vector<double> unused;
    residual(unused);
    last_outside.assign(p.internal->array().begin(),
                        p.internal->array().begin() + static_cast<std::ptrdiff_t>(fixed.size()));
    commit();
  }

  /// Moves by `part` of a correction, halved up to three times until the residual is `enough`. False: no answer.
  bool search(const std::vector<double>& dx, double to, double sofar, double enough, std::vector<double>& r,
              double& part, double& next) {
    // A correction larger than all that was moved so far is no correction: grains would be driven through strains
    // that nobody asked for. It is cut to that size.
    const double size = largest(dx);
    part = sofar > 0 && size > sofar ? sofar / size : 1;
    move(dx, part);
    for (int cut = 0;; ++cut) {
      if (!evaluate(to)) return false;
      next = residual(r);
      if (next <= enough || cut == 3) return true;
      move(dx, -0.5 * part);
      part *= 0.5;
    }
  }

  /// One increment of the load factor from the committed state; false: nothing was committed.
  bool increment(double from, double to, IncrementReport& report) {
    std::vector<double> r, dx, total;
    p.assemble_external(to);
    residual(r);  // with the committed stress: out of balance by the new load only
    if (goes_on(from, to))
      dx = as_before(to - from);
    else if (!linear.solve(r, from, to, dx)) {
      reason = "the linear solver failed";
      return false;
    }
    move(dx, 1);
    total = dx;
    if (!evaluate(to)) return false;
    double now = residual(r), correction = 1;
    report.residuals.assign(1, now);
    double best = now;
    int idle = 0;  // iterations since the residual last fell by a tenth
    constexpr int patience = 8;
    Acceleration acceleration(p.comm, static_cast<std::size_t>(o.acceleration));
    for (report.iterations = 1; report.iterations <= o.max_iterations; ++report.iterations) {
      // Corrections are judged against the increment that was asked for: cutting it does not make the material less
      // noisy. Where no load changes nothing moves but by round-off.
      const double moved =
          std::max(largest(total) * std::max(1.0, 1 / (o.increments * (to - from))), still * farthest());
      const double noise = largest_of_ranks(material.noise());
      const double floor = std::max(o.tolerance, noise), floor_u = std::max(o.displacement_tolerance, 2 * noise);
      if (!linear.solve(r, to, to, dx)) {
        reason = "the linear solver failed";
        return false;
      }
      if (o.acceleration > 0) dx = acceleration.step(dx);
      correction = moved > 0 ? largest(dx) / moved : 0;
      // What Newton would still change is known before it is done: a converged state costs no further material sweep.
      if (now <= floor && correction <= floor_u) {
        report.residual = now;
        report.correction = correction;
        report.noise = noise;
        accept(to - from);
        return true;
      }
      double part = 1, next = now;
      if (!search(dx, to, largest(total), std::max(1.1 * now, floor), r, part, next)) return false;
      acceleration.moved(dx, part);
      if (next > 1.1 * now && next > floor) acceleration.forget();
      for (std::size_t i = 0; i < total.size(); ++i) total[i] += part * dx[i];
      now = next;
      report.residuals.push_back(now);
      if (now < 0.9 * best)
        best = now, idle = 0;
      else if (++idle == patience && best > 3 * floor) {
        reason = "no progress in " + std::to_string(patience) + " iterations";
        return false;
      }
    }
    reason = "no convergence in " + std::to_string(o.max_iterations) + " iterations";
    return false;
  }
};

}  // namespace

StaticsResult solve_statics(Problem& problem, Material& material, const StaticsOptions& o,
                            const std::function<bool(const IncrementReport&)>& observer, const StaticsStart& start) {
  Problem::Impl& p = problem.impl();
  Newton newton(p, material, o);
  newton.go_on(start);
  StaticsResult result;
  const double asked = 1.0 / o.increments;
  double size = start.next_size > 0 ? start.next_size : asked;
  int cutbacks = 0, number = start.increments;
  result.load_factor = start.load_factor;
  if (number == 0) {  // stress and tangent of the start: an empty increment
    if (!newton.evaluate(0)) {
      result.failure = "the initial state: " + newton.reason;
      return result;
    }
  }
  newton.begin(number > 0, result.load_factor);
  std::string cut_reason;
  while (result.load_factor < 1 - 1e-12) {
    double next = std::min(1.0, result.load_factor + size);
    if (1 - next < 1e-9 * asked) next = 1;
    IncrementReport report{number + 1, next, 0, cutbacks, 0, 0, 0, cut_reason, {}, {}, 0, 0, 0, 0, 0};
    if (!newton.increment(result.load_factor, next, report)) {
      p.back_to_committed();
      newton.last_size = 0;
      cut_reason = newton.reason;
      result.law_sweeps = newton.sweeps;
      if (newton.sharpen()) continue;  // the same increment once more
      if (++cutbacks > o.max_cutbacks) {
        result.failure = "increment " + std::to_string(number + 1) + " failed after " + std::to_string(o.max_cutbacks) +
                         " cutbacks: " + cut_reason;
        return result;
      }
      if ((size *= o.cut) < o.least * asked) {  // creeping up to a load that cannot be carried
        result.failure = "increment " + std::to_string(number + 1) + " became too small: " + cut_reason;
        return result;
      }
      continue;
    }
    ++number;
    result.load_factor = next;
    result.law_sweeps = newton.sweeps;
    report.next_size = size = std::min(asked, cutbacks > 0 ? size : size * o.grow);
    newton.tell(report);
    cutbacks = 0;
    cut_reason.clear();
    if (!observer(report)) {
      result.stopped = true;
      return result;
    }
  }
  result.converged = true;
  return result;
}

}  // namespace grus::fem
