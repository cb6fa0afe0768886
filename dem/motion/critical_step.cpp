// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/motion/critical_step.hpp"

#include <algorithm>
#include <numeric>

namespace grus::dem {

CriticalStep critical_step(const ContactLaw& law, std::span<const PairLaw> pairs, std::size_t materials,
                           const Grains& g, const Boundary& boundary, const Contacts& contacts, const Bonds& bonds) {
  Team alone(1);
  return critical_step(HeldGrains(law, pairs, materials, g, boundary, contacts, bonds, 0, alone), false);
}

CriticalStep critical_step(const HeldGrains& held, bool touch_only, double safety) {
  const Grains& g = held.grains();
  const std::size_t n = g.size();
  CriticalStep critical;
  critical.max_speed = held.max_speed();
  const std::vector<double> bound = held.cheap_bounds();
  std::vector<std::uint8_t> touched;
  if (touch_only) touched = held.touched();
  std::vector<double> impact(n);
  for (std::size_t i = 0; i < n; ++i) impact[i] = touch_only && touched[i] ? 0 : held.impact(i, g.mass[i]);

  // Exact 6 x 6 eigenvalues only where the bound could set the step.
  std::vector<Index> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    const double x = std::max(bound[a], impact[a]), y = std::max(bound[b], impact[b]);
    return x != y ? x > y : a < b;
  });
  double worst = 0;
  for (const Index i : order) {
    if (std::max(bound[i], impact[i]) <= worst) break;
    const Mat6 scaled = held.stiffness(i);
    const double slow = held.resisted() ? largest_eigenvalue(held.resistance(i)) : 0;
    if (std::max(with_dashpots(largest_eigenvalue_bound(scaled), slow), impact[i]) <= worst) continue;
    const double value = std::max(with_dashpots(largest_eigenvalue(scaled), slow), impact[i]);
    if (value > worst) worst = value, critical.grain = i, critical.impact = value == impact[i];
  }
  if (worst > 0) critical.dt = 2 / std::sqrt(worst);
  if (held.damped()) {
    const std::vector<double> drag = held.cheap_drags();
    std::vector<double> most(n);
    for (std::size_t i = 0; i < n; ++i) most[i] = drag[i] > 0 ? with_dashpots(bound[i], drag[i]) : 0;
    std::sort(order.begin(), order.end(), [&](Index a, Index b) { return most[a] > most[b]; });
    const double idle = std::pow(damped_safety / safety, 2) * worst;
    double fastest = idle;
    for (const Index i : order) {
      if (most[i] <= fastest) break;
      const Mat6 stiff = held.stiffness(i), viscous = held.drag(i);
      if (with_dashpots(largest_eigenvalue_bound(stiff), largest_eigenvalue_bound(viscous)) <= fastest) continue;
      fastest = std::max(fastest, with_dashpots(largest_eigenvalue(stiff), largest_eigenvalue(viscous)));
    }
    if (fastest > idle) critical.damped = 2 / std::sqrt(fastest);
  }
  // No grain moves by more than a twentieth of its smallest width in a step.
  for (std::size_t i = 0; i < n; ++i) {
    const double speed = g.motion[i].velocity.norm() + g.motion[i].spin.norm() * g.motion[i].radius + held.wall_speed();
    if (speed > 0) {
      const double least = 0.05 * g.extent[i].least_width / speed;
      if (least < critical.dt) critical.dt = least, critical.grain = i, critical.outrun = true;
    }
  }
  return critical;
}

double share_of_turning(const HeldGrains& held, const CriticalStep& critical) {
  if (critical.outrun) return NAN;
  if (critical.impact) return 0;
  const Eigen::SelfAdjointEigenSolver<Mat6> eigen(held.stiffness(critical.grain));
  return eigen.eigenvectors().col(5).tail<3>().squaredNorm();
}

}  // namespace grus::dem
