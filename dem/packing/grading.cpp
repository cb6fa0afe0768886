// SPDX-License-Identifier: LGPL-3.0-or-later
// Radii by number from gradings by mass.
#include <algorithm>

#include "dem/base/random.hpp"
#include "dem/packing/packing.hpp"

namespace grus::dem {
namespace {

double inverse_cube(double r) { return 1 / (r * r * r); }

/// Mass even in log r between two sieves: by number as r^-4, whose integrals are closed.
double of_sieves(const RadiusDistribution& d, std::uint64_t seed, std::uint64_t i) {
  double all = 0;
  for (std::size_t k = 0; k + 1 < d.sieve.size(); ++k) all += sieve_class(d, k).number;
  double left = all * random_uniform(seed, i, Purpose::radius);
  std::size_t k = 0;
  for (; k + 2 < d.sieve.size() && left > sieve_class(d, k).number; ++k) left -= sieve_class(d, k).number;
  const double low = inverse_cube(d.sieve[k][0]), high = inverse_cube(d.sieve[k + 1][0]);
  const double within = std::clamp(left / std::max(sieve_class(d, k).number, 1e-300), 0.0, 1.0);
  return 1 / std::cbrt(low + (high - low) * within);
}

}  // namespace

SieveClass sieve_class(const RadiusDistribution& d, std::size_t k) {
  const double a = d.sieve[k][0], b = d.sieve[k + 1][0], mass = d.sieve[k + 1][1] - d.sieve[k][1];
  const double cubes = inverse_cube(a) - inverse_cube(b);
  return {mass * cubes / (3 * std::log(b / a)), 1.5 * (1 / (a * a) - 1 / (b * b)) / cubes};
}

double RadiusDistribution::mean_cube() const {
  if (kind == "uniform" && max > min) return 0.25 * (std::pow(max, 4) - std::pow(min, 4)) / (max - min);
  if (kind == "log-normal") return std::pow(median, 3) * std::exp(-4.5 * spread * spread);  // its tails left in
  if (kind == "sieve") {
    double number = 0;
    for (std::size_t k = 0; k + 1 < sieve.size(); ++k) number += sieve_class(*this, k).number;
    return 1 / number;
  }
  return std::pow(mean, 3) + 3 * mean * sd * sd;  // the ends of a normal's tails left out
}

double draw_radius(const RadiusDistribution& d, std::uint64_t seed, std::uint64_t i) {
  if (d.kind == "uniform") return d.min + (d.max - d.min) * random_uniform(seed, i, Purpose::radius);
  if (d.kind == "sieve") return of_sieves(d, seed, i);
  const bool normal = d.kind == "truncated-normal", log_normal = d.kind == "log-normal";
  for (std::uint64_t k = 0; (normal || log_normal) && k < 10000; ++k) {
    const double z = random_normal(seed, i, Purpose::radius, k);
    // By mass log-normal about the median: by number about median exp(-3 spread^2), as wide.
    const double r = normal ? d.mean + d.sd * z : d.median * std::exp(d.spread * z - 3 * d.spread * d.spread);
    if (r >= d.min && r <= d.max) return r;
  }
  return d.mean;
}

}  // namespace grus::dem
