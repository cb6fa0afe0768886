// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/bursts.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

/// Mean and variance of ln s where s has the probability s^-exponent / sum, s = 1 to `largest`.
struct LogMoments {
  double mean, variance;
};

LogMoments log_moments(double exponent, std::size_t largest) {
  double sum = 0, first = 0, second = 0;
  for (std::size_t s = 1; s <= largest; ++s) {
    const double ln = std::log(static_cast<double>(s)), weight = std::exp(-exponent * ln);
    sum += weight, first += weight * ln, second += weight * ln * ln;
  }
  return {first / sum, second / sum - first / sum * (first / sum)};
}

}  // namespace

std::vector<Burst> bursts_of(std::span<const BrokenBond> broken, double window) {
  std::vector<Burst> bursts;
  for (const BrokenBond& b : broken) {
    const double start = window * std::floor(b.time / window);
    if (bursts.empty() || start > bursts.back().time) bursts.push_back({start});
    Burst& now = bursts.back();
    ++now.bonds, now.energy += b.energy, now.area += b.area, now.middle += b.area * b.at;
  }
  for (Burst& b : bursts) b.middle /= b.area;
  return bursts;
}

PowerLaw fit_power_law(std::span<const Burst> bursts) {
  std::size_t largest = 0;
  double mean = 0;
  for (const Burst& b : bursts) {
    largest = std::max(largest, b.bonds);
    mean += std::log(static_cast<double>(b.bonds)) / static_cast<double>(bursts.size());
  }
  if (mean == 0 || log_moments(-20, largest).mean < mean) return {};
  double low = -20, high = 40;  // the mean falls as the exponent grows
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (log_moments(middle, largest).mean > mean ? low : high) = middle;
  }
  const double variance = log_moments(low, largest).variance;
  return {low, 1 / std::sqrt(variance * static_cast<double>(bursts.size()))};
}

}  // namespace grus::dem
