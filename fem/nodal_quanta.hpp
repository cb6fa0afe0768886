// SPDX-License-Identifier: LGPL-3.0-or-later
// Nodal sums whose bits depend neither on the elements' order nor on the ranks that hold them.
#pragma once

#include <mpi.h>

#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fem/dolfinx_compat.hpp"

namespace grus::fem {

/// What an element adds to a component of a local node.
struct Contribution {
  std::int32_t at;
  double value;
};

/// Contributions are rounded to multiples of one quantum, 2^-50 of the power of two above the largest on any rank, and
/// added as integers: associative, so that shared nodes may be summed in any order. Each is off by half a quantum at
/// most, 2^-50 of the largest; 2^12 may meet at a node.
class NodalQuanta {
public:
  NodalQuanta(MPI_Comm comm, const std::shared_ptr<const dolfinx::common::IndexMap>& map, int components)
      : comm_(comm), sum_(map, components) {}

  /// The largest of this rank, without its sign; infinite where one is no number.
  static double largest(std::span<const Contribution> parts);
  static double largest(std::span<const double> values);
  /// The sums at owned nodes, all components; NaN everywhere where a contribution on any rank is no number.
  void add_up(std::span<const Contribution> parts, std::span<double> owned);
  /// The same where the largest on any rank is known.
  void add_up(std::span<const Contribution> parts, double of_all, std::span<double> owned);
  /// The same of what `give(add)` gives, `add(at, value)`.
  template <class Give>
  void add_up(double of_all, std::span<double> owned, Give&& give) {
    double up = 0, quantum = 0;
    if (!begin(of_all, owned, up, quantum)) return;
    auto sum = sum_.mutable_array();
    give([&](std::int32_t at, double value) { sum[static_cast<std::size_t>(at)] += rounded(value * up); });
    end(quantum, owned);
  }

private:
  /// To the nearest integer, of two the even one; for numbers below 2^51.
  static std::int64_t rounded(double v) {
    constexpr double units = 0x1.8p52;  // doubles near it are the integers
    return std::bit_cast<std::int64_t>(v + units) - std::bit_cast<std::int64_t>(units);
  }
  bool begin(double of_all, std::span<double> owned, double& up, double& quantum);
  void end(double quantum, std::span<double> owned);

  MPI_Comm comm_;
  dolfinx::la::Vector<std::int64_t> sum_;
};

}  // namespace grus::fem
