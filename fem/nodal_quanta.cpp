// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/nodal_quanta.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace grus::fem {

double NodalQuanta::largest(std::span<const Contribution> parts) {
  double most = 0;
  bool good = true;
  for (const Contribution& c : parts) {
    good = good && std::isfinite(c.value);
    most = std::max(most, std::abs(c.value));
  }
  return good ? most : INFINITY;
}

void NodalQuanta::add_up(std::span<const Contribution> parts, std::span<double> owned) {
  const double most = largest(parts);
  double of_all = 0;
  MPI_Allreduce(&most, &of_all, 1, MPI_DOUBLE, MPI_MAX, comm_);
  add_up(parts, of_all, owned);
}

void NodalQuanta::add_up(std::span<const Contribution> parts, double of_all, std::span<double> owned) {
  if (!std::isfinite(of_all)) return std::fill(owned.begin(), owned.end(), std::numeric_limits<double>::quiet_NaN());
  int exponent = 0;
  std::frexp(of_all, &exponent);
  exponent = std::max(exponent, -900);  // the quantum itself must be a number
  const double up = std::ldexp(1.0, 50 - exponent), quantum = std::ldexp(1.0, exponent - 50);
  sum_.set(0);
  auto sum = sum_.mutable_array();
  for (const Contribution& c : parts) sum[static_cast<std::size_t>(c.at)] += std::llrint(c.value * up);
  sum_.scatter_rev(std::plus<std::int64_t>());
  for (std::size_t i = 0; i < owned.size(); ++i) owned[i] = static_cast<double>(sum[i]) * quantum;
}

}  // namespace grus::fem
