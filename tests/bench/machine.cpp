// SPDX-License-Identifier: LGPL-3.0-or-later
#include "tests/bench/machine.hpp"

#include <algorithm>
#include <chrono>
#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/kernel/contact_pass.hpp"

namespace grus::bench {
namespace {

template <class F>
double fastest(F&& work) {
  double best = 1e300;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

}  // namespace

double gigaflops(int threads) {
  const long rounds = 20000000 / threads;
  dem::Team team(threads);
#if defined(GRUS_WIDE_KERNELS)
  const auto loop =
      dem::of_width(&lanes1::multiply_add_rounds, &lanes4::multiply_add_rounds, &lanes8::multiply_add_rounds);
  const int each = dem::of_width(lanes1::flops_a_round, lanes4::flops_a_round, lanes8::flops_a_round);
#else
  const auto loop = lanes1::multiply_add_rounds;
  const int each = lanes1::flops_a_round;
#endif
  const double took = fastest([&] {
    team.each(static_cast<std::size_t>(threads), [&](std::size_t) {
      double sink[80];
      loop(rounds, sink);
    });
  });
  return static_cast<double>(rounds) * threads * each / took / 1e9;
}

double update_bandwidth(double bytes) {
  std::vector<double> room(static_cast<std::size_t>(bytes / 8), 1.0);
  const int times = static_cast<int>(2e8 / bytes) + 2;
#if defined(GRUS_WIDE_KERNELS)
  const auto loop = dem::of_width(&lanes1::update, &lanes4::update, &lanes8::update);
#else
  const auto loop = lanes1::update;
#endif
  const double took = fastest([&] {
    for (int k = 0; k < times; ++k) loop(room.data(), room.size(), 0.999999);
  });
  return 8.0 * static_cast<double>(room.size()) * times / took / 1e9;
}

}  // namespace grus::bench
