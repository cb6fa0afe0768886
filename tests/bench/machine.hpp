// SPDX-License-Identifier: LGPL-3.0-or-later
// What the machine can do, with the kernels' own instruction set: one thread.
#pragma once

#include <cstddef>

namespace grus::bench {

#define GRUS_DECLARE_MACHINE(name)                       \
  namespace name {                                       \
  double multiply_add_rounds(long rounds, double* sink); \
  void update(double* at, std::size_t count, double by); \
  extern const int flops_a_round;                        \
  }
GRUS_DECLARE_MACHINE(lanes1)
GRUS_DECLARE_MACHINE(lanes4)
GRUS_DECLARE_MACHINE(lanes8)
#undef GRUS_DECLARE_MACHINE

/// Multiplications and additions, each rounded, a second (10^9), of so many threads together.
double gigaflops(int threads = 1);

/// Bytes a second (10^9), each counted once, of reading and writing back `bytes` over and over.
double update_bandwidth(double bytes);

}  // namespace grus::bench
