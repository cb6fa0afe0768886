// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/bond_strength.hpp"

#include <algorithm>
#include <tuple>

#include "dem/base/error.hpp"
#include "dem/base/random.hpp"

namespace grus::dem {
namespace {

/// Stiffnesses of half a bond (Pa/m): normal, tangential.
std::array<double, 2> half_stiffness(const BondModel& model, double depth) {
  const double kn =
      model.stiffness_given ? 2 * model.stiffness : model.stiffness / (model.length > 0 ? 0.5 * model.length : depth);
  return {kn, model.ratio * kn};
}

}  // namespace

double bond_length(const BondModel& model, double apart) { return model.length > 0 ? model.length : apart; }

void set_stiffness(const BondModel& model, double apart, FaceBond& s) {
  s.kn = model.stiffness_given ? model.stiffness : model.stiffness / bond_length(model, apart);
  s.kt = model.ratio * s.kn;
}

void set_stiffness(const BondModel& a, double depth_a, const BondModel& b, double depth_b, FaceBond& s) {
  const auto one = half_stiffness(a, depth_a), other = half_stiffness(b, depth_b);
  s.kn = 1 / (1 / one[0] + 1 / other[0]), s.kt = 1 / (1 / one[1] + 1 / other[1]);
}

const BondModel& weaker_of(const BondModel& a, const BondModel& b) {
  if (a.criterion != b.criterion)
    throw InputError("bonds of two materials that meet have different criteria: give them one");
  return std::tie(b.tension, b.cohesion) < std::tie(a.tension, a.cohesion) ? b : a;
}

void give_strength(const BondModel& model, double share, std::uint64_t seed, std::uint64_t id, double h, FaceBond& s,
                   bool& coarse) {
  double factor = share;
  if (model.weibull > 0) {
    const double mean = std::tgamma(1 + 1 / model.weibull);
    factor *= std::pow(-std::log(random_uniform(seed, id, Purpose::strength, 1)), 1 / model.weibull) / mean;
  }
  s.criterion = model.criterion;
  s.tension = factor * model.tension, s.cohesion = factor * model.cohesion;
  s.tan_phi = model.tan_phi, s.friction = model.friction;
  s.energy_1 = share * share * model.energy_1, s.energy_2 = share * share * model.energy_2;
  if (s.criterion == FaceCriterion::strain_sum) s.tension *= h;  // an opening
  if (s.criterion != FaceCriterion::cohesive) return;
  const double room = 0.95, limit = room * softening_limit(s.kn, s.energy_1);
  const double limit_shear = room * softening_limit(s.kt, s.energy_2);
  coarse = s.tension > limit || s.cohesion > limit_shear;
  s.tension = std::min(s.tension, limit), s.cohesion = std::min(s.cohesion, limit_shear);
}

}  // namespace grus::dem
