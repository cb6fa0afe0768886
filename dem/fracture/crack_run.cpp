// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/crack_run.hpp"

#include <algorithm>

namespace grus::dem {

HoldTest hold_test(PeridynamicSolid& solid, const PointColumns& load, PointColumns& u, const HoldLimits& limits) {
  HoldTest test;
  const double intact = dot(load, u);
  PointColumns next = u;
  bool settled = true;  // u is the answer, and not near it
  for (;;) {
    const bool breaks = solid.break_above(u, 1, test.lost) > 0;
    if (!breaks && settled) {
      test.verdict = Hold::holds;
      return test;
    }
    if (breaks && (test.rounds == limits.rounds || test.work > limits.work)) return test;
    settled = !breaks;
    long sweeps = 0;
    const int took =
        solve(solid, load, next, settled ? HoldLimits::tolerance : HoldLimits::coarse, HoldLimits::iterations, sweeps);
    test.iterations += static_cast<int>(sweeps), ++test.solves;
    const double work = dot(load, next) / intact;
    if (took < 0 || work > limits.failed) {
      test.verdict = Hold::fails;
      return test;
    }
    u = next, test.work = work, test.rounds += breaks;
  }
}

LastHold last_hold(PeridynamicSolid& solid, const PointColumns& load, const PointColumns& whole, PointColumns& u) {
  constexpr int least = 512;  // a load of 1e-11 of the whole breaks nothing
  LastHold last;
  PointColumns part = load, at_rest = u;
  std::vector<std::uint8_t> intact;
  LastHold kept;  // the last that holds, with its answer and its bonds
  int rounds = 0, iterations = 0, solves = 0, at = 0;
  const auto holds = [&](int power) {
    last.share = std::pow(CrackChoice::raise, -power);
    for (std::size_t k = 0; k < part.size(); ++k) part[k] = last.share * load[k], u[k] = last.share * whole[k];
    solid.mend();
    last.test = hold_test(solid, part, u);
    rounds += last.test.rounds, iterations += last.test.iterations, solves += last.test.solves;
    if (!last.test.holds()) return false;
    kept = last, at_rest = u, intact = solid.intact(), at = power;
    return true;
  };
  solid.mend(), solid.dilate(whole);
  // What is not stretched beyond its limit holds.
  const double powers = std::log(solid.largest_breakable_stretch()) / std::log(CrackChoice::raise);
  int fails = 0, held = static_cast<int>(std::clamp(std::ceil(powers), 1.0, double{least}));
  while (held - fails > 1) {
    const int middle = (held + fails) / 2;
    (holds(middle) ? held : fails) = middle;
  }
  while (at != held && !holds(held) && held < least) ++held;  // of round-off
  if (at == held) last = kept, u = at_rest, solid.intact() = intact;
  last.test.rounds = rounds, last.test.iterations = iterations, last.test.solves = solves;
  return last;
}

namespace {

double largest(const PointColumns& u) {
  double most = 0;
  for (std::size_t k = 0; k < u.size(); ++k) most = std::max(most, std::abs(u[k]));
  return most;
}

}  // namespace

CrackRun crack_run(PeridynamicSolid& solid, const PointColumns& load, PointColumns& u, const CrackChoice& choice,
                   double share) {
  constexpr int each = 10;  // steps from look to look
  const std::size_t n = u.size();
  const double step = 0.9 * 2 / solid.highest_frequency(), speed = solid.wave_speed();
  const double half = 0.5 * choice.damping * speed * step, keep = (1 - half) / (1 + half);
  const double kick = step / (1 + half) / solid.lattice().volume;
  const int quiet = static_cast<int>(CrackChoice::quiet / (speed * step)) + 1;
  const int pause = static_cast<int>(CrackChoice::pause / (speed * step)) + 1;
  const int after = static_cast<int>(choice.time / (speed * step)) + 1;
  CrackRun run;
  run.load_factor = share;
  PointColumns velocity(solid.lattice().size()), force = velocity;
  int raised = 0, since_break = 0, since_raise = 0, since_parted = -1;
  bool looked = false;
  const double torn = CrackChoice::torn * largest(u) / share;
  solid.dilate(u);
  for (;;) {
    solid.pull(force);
    for (std::size_t k = 0; k < n; ++k) {
      velocity[k] = keep * velocity[k] + kick * (force[k] + run.load_factor * load[k]);
      u[k] += step * velocity[k];
    }
    ++run.steps, ++since_break, ++since_raise;
    if (solid.break_above(u, 1, run.lost) > 0) since_break = 0, looked = false;
    if (since_parted >= 0) ++since_parted;
    if (run.steps % each == 0 || since_parted == after) {
      if (!looked) {  // since a bond broke
        Clusters seen = clusters_of(solid, choice.smallest_piece, choice.crumbs);
        if (seen.pieces > 1) run.clusters = std::move(seen), since_parted = std::max(since_parted, 0);
        looked = true;
      }
      if (since_parted < 0 && largest(u) > torn) {
        run.clusters = torn_apart(solid, u, choice.smallest_piece, choice.crumbs);
        if (run.clusters.pieces + run.clusters.crumbs > 1) run.end = CrackEnd::parts;
        return run;
      }
    }
    if (since_parted == after) {
      run.end = CrackEnd::parts;
      return run;
    }
    if (run.steps == CrackChoice::most_in_all) return run;
    const bool whole = run.load_factor >= 1, still = since_break > (whole ? quiet : pause);
    if (since_parted >= 0 || (!still && since_raise < CrackChoice::most_steps)) continue;
    if (still && whole) {
      run.end = CrackEnd::holds;
      return run;
    }
    if (whole && raised++ == CrackChoice::raises) return run;
    run.load_factor *= CrackChoice::raise, since_raise = since_break = 0;
    if (!whole) run.load_factor = std::min(run.load_factor, 1.0);
  }
}

}  // namespace grus::dem
