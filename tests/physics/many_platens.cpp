// SPDX-License-Identifier: LGPL-3.0-or-later
// Many grains between platens, each of its own draw and its own lattice: the scatter and the size effect that come out
// are those of the law.
#include "dem/fracture/fracture_model.hpp"
#include "tests/lattices.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// Modulus of Weibull's law by the largest likelihood.
double modulus_of(const std::vector<double>& x) {
  const double n = static_cast<double>(x.size());
  double logs = 0, low = 0.1, high = 50;
  for (const double v : x) logs += std::log(v) / n;
  for (int k = 0; k < 60; ++k) {
    const double m = 0.5 * (low + high);
    double sum = 0, weighted = 0;
    for (const double v : x) sum += std::pow(v, m), weighted += std::pow(v, m) * std::log(v);
    (weighted / sum - 1 / m - logs > 0 ? high : low) = m;
  }
  return low;
}

/// The largest F/d^2 (Pa) that a sphere holds, in steps of 1 %.
double strength_of(double d, double factor, std::uint64_t id, const LatticeModel& m, const LatticeToughness& t) {
  const double stretch = t.stretch(m.lattice, youngs, poisson, d, factor);
  const auto holds = [&](double pressure) {
    const CrackVerdict v =
        crack_test(lattice_sphere(0.5 * d), pressed(d, pressure * d * d), m, stretch, 11, id).verdict;
    return v == CrackVerdict::core_holds || v == CrackVerdict::holds;
  };
  double low = 20e6 * factor, high = 80e6 * factor;
  REQUIRE((holds(low) && !holds(high)));
  while (high > 1.01 * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

}  // namespace

TEST_CASE("a grain's draw and its lattice are all that tells its strength, whatever its size") {
  LatticeModel m;
  m.lattice = lattice_of(300), m.youngs_modulus = youngs, m.poissons_ratio = poisson;
  const LatticeToughness t{.energy = 30, .reference_diameter = 2e-3};
  double least = INFINITY, most = 0;
  for (std::uint64_t id = 0; id < 4; ++id) {
    const double one = strength_of(2e-3, 1, id, m, t);
    CHECK(strength_of(1e-3, 1.7, id, m, t) == Approx(1.7 * one).epsilon(1e-9));
    least = std::min(least, one), most = std::max(most, one);
  }
  CHECK(most > 1.01 * least);
}

TEST_CASE("a thousand grains of two sizes: Weibull's modulus, and the ratio that it asks for", "[.slow]") {
  LatticeModel m;
  m.lattice = lattice_of(300), m.youngs_modulus = youngs, m.poissons_ratio = poisson;
  const LatticeToughness t{.energy = 30, .reference_diameter = 2e-3};
  const Weibull law{3.1, 1e-3, 3 / 3.1};
  double mean[2] = {0, 0};
  for (const int small : {0, 1}) {
    const double d = small ? 1e-3 : 2e-3;
    std::vector<double> strength;
    for (std::uint64_t id = 0; id < 500; ++id) {
      const std::uint64_t grain = 500 * static_cast<std::uint64_t>(small) + id;
      strength.push_back(strength_of(d, law(0.5 * d, 5, grain), grain, m, t));
      mean[small] += strength.back() / 500;
    }
    CHECK(modulus_of(strength) == Approx(3.1).epsilon(0.1));
  }
  // Four standard errors of means of 500 that scatter by 0.36.
  CHECK(mean[1] / mean[0] == Approx(1.956).epsilon(4 * 0.36 * std::sqrt(2.0 / 500)));
}
