// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/model.hpp"

#include <map>

namespace grus::dem {
namespace {

/// What is rigid and names a friction decides; what is rigid and names none takes the other's; else the lower.
double friction_of(const Material& a, const Material& b) {
  const bool rigid_a = std::isinf(a.youngs_modulus), rigid_b = std::isinf(b.youngs_modulus);
  if (rigid_a && !std::isnan(a.friction)) return a.friction;
  if (rigid_b && !std::isnan(b.friction)) return b.friction;
  if (rigid_a) return b.friction;
  if (rigid_b) return a.friction;
  return std::min(a.friction, b.friction);
}

/// The grain's against what is rigid; else the lower. Nothing resists a turn where nothing resists sliding.
double couple_friction_of(SpringRow row, const Material& a, const Material& b) {
  if (!(friction_of(a, b) > 0)) return 0;
  if (std::isinf(a.youngs_modulus)) return b.couple_friction(row);
  if (std::isinf(b.youngs_modulus)) return a.couple_friction(row);
  return std::min(a.couple_friction(row), b.couple_friction(row));
}

/// The grain's against what is rigid; else the mean.
double restitution_of_pair(const Material& a, const Material& b) {
  if (std::isinf(a.youngs_modulus)) return b.restitution;
  if (std::isinf(b.youngs_modulus)) return a.restitution;
  return 0.5 * (a.restitution + b.restitution);
}

}  // namespace

void renew_friction(Model& model) {
  const std::size_t n = model.materials.size();
  model.damping.clear();
  for (const Material& m : model.materials) model.damping.push_back(m.damping);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      const Material &a = model.materials[i], &b = model.materials[j];
      PairLaw& p = model.pairs[i * n + j];
      p.friction[slide_spring] = friction_of(a, b);
      for (const SpringRow row : couple_springs) p.friction[row] = couple_friction_of(row, a, b);
    }
}

void make_pair_laws(Model& model) {
  const std::size_t n = model.materials.size();
  model.pairs.assign(n * n, {});
  renew_friction(model);
  std::map<double, double> dashpots;  // solved once for each restitution
  auto dashpot = [&](double e) {
    if (!dashpots.contains(e)) dashpots[e] = dashpot_for(model.law, e);
    return dashpots[e];
  };
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      const Material &a = model.materials[i], &b = model.materials[j];
      PairLaw& p = model.pairs[i * n + j];
      p.dashpot = dashpot(restitution_of_pair(a, b));
      mix(model.law, a.solid(), a.contact, b.solid(), b.contact, p);
    }
}

void set_damping(Model& model, double damping) {
  for (Material& m : model.materials) m.damping = m.fixed ? 0 : damping;
  model.damping.clear();
  for (const Material& m : model.materials) model.damping.push_back(m.damping);
}

}  // namespace grus::dem
