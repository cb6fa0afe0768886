// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/nodal_quanta.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace grus::fem {

namespace {

/// What is no number is no maximum either: it is kept apart.
struct Largest {
  double most = 0;
  bool good = true;
  void look(double value) {
    good = good && std::isfinite(value);
    most = std::max(most, std::abs(value));
  }
  double told() const { return good ? most : INFINITY; }
};

}  // namespace

double NodalQuanta::largest(std::span<const Contribution> parts) {
  Largest all;
  for (const Contribution& c : parts) all.look(c.value);
  return all.told();
}

double NodalQuanta::largest(std::span<const double> values) {
  Largest all;
  for (const double v : values) all.look(v);
  return all.told();
}

void NodalQuanta::add_up(std::span<const Contribution> parts, std::span<double> owned) {
  const double most = largest(parts);
  double of_all = 0;
  MPI_Allreduce(&most, &of_all, 1, MPI_DOUBLE, MPI_MAX, comm_);
  add_up(parts, of_all, owned);
}

void NodalQuanta::add_up(std::span<const Contribution> parts, double of_all, std::span<double> owned) {
  add_up(of_all, owned, [&](auto&& add) {
    for (const Contribution& c : parts) add(c.at, c.value);
  });
}

/// False: there is nothing to be added up.
bool NodalQuanta::begin(double of_all, std::span<double> owned, double& up, double& quantum) {
  if (!std::isfinite(of_all)) {
    std::fill(owned.begin(), owned.end(), std::numeric_limits<double>::quiet_NaN());
    return false;
  }
  int exponent = 0;
  std::frexp(of_all, &exponent);
  exponent = std::max(exponent, -900);  // the quantum itself must be a number
  up = std::ldexp(1.0, 50 - exponent), quantum = std::ldexp(1.0, exponent - 50);
  sum_.set(0);
  return true;
}

void NodalQuanta::end(double quantum, std::span<double> owned) {
  sum_.scatter_rev(std::plus<std::int64_t>());
  const auto sum = sum_.array();
  for (std::size_t i = 0; i < owned.size(); ++i) owned[i] = static_cast<double>(sum[i]) * quantum;
}

}  // namespace grus::fem
