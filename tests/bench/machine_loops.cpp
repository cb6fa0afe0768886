// SPDX-License-Identifier: LGPL-3.0-or-later
// Built once for each instruction set, as the kernels are.
#include "dem/kernel/lanes.hpp"
#include "tests/bench/machine.hpp"

namespace grus::bench::GRUS_LANES {

using namespace grus::dem;

extern const int flops_a_round = 10 * 2 * width;

double multiply_add_rounds(long rounds, double* sink) {
  Real x[10];
  for (int k = 0; k < 10; ++k) x[k] = Real(1.0 + 1e-3 * k);
  const Real a(0.999999), b(1e-6);
  for (long i = 0; i < rounds; ++i)
    for (int k = 0; k < 10; ++k) x[k] = fused(x[k], a, b);
  for (int k = 0; k < 10; ++k) store(x[k], sink + 8 * k);
  return sink[0];
}

void update(double* at, std::size_t count, double by) {
  const Real factor(by);
  for (std::size_t i = 0; i + width <= count; i += width) {
    Real x;
    load(at + i, x);
    store(factor * x, at + i);
  }
}

}  // namespace grus::bench::GRUS_LANES
