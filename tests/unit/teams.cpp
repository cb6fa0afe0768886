// SPDX-License-Identifier: LGPL-3.0-or-later
// Threads: everything is done once whoever comes, and nobody is asked to help where help does not pay.
#include <chrono>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <numeric>
#include <thread>

#include "dem/base/parallel.hpp"
#include "tests/catch.hpp"

using namespace grus::dem;

TEST_CASE("every index is met once by blocks, pieces and single jobs, with more threads than the machine has cores") {
  for (const int threads : {1, 2, 7, 32}) {
    Team team(threads);
    std::vector<std::uint32_t> by_block(5000), by_piece(100), by_job(50);
    std::vector<std::uint64_t> load(101);
    for (std::size_t k = 0; k < load.size(); ++k) load[k] = k * k;
    for (int round = 0; round < 300; ++round) {
      team.blocks(by_block.size(), [&](std::size_t b, std::size_t e) {
        for (std::size_t i = b; i < e; ++i) ++by_block[i];
      });
      team.pieces(by_piece.size(), load, [&](std::size_t b, std::size_t e, int rank) {
        for (std::size_t i = b; i < e; ++i) by_piece[i] += rank < threads;
      });
      team.each(by_job.size(), [&](std::size_t i) { ++by_job[i]; });
    }
    for (const auto* all : {&by_block, &by_piece, &by_job})
      CHECK(std::count(all->begin(), all->end(), 300u) == static_cast<std::ptrdiff_t>(all->size()));
  }
}

TEST_CASE("who waits long for another's job sleeps") {
  using namespace std::chrono_literals;
  const auto spent = [] {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  Team team(2);
  std::atomic<int> begun{0};
  const auto caller = std::this_thread::get_id();
  const double before = spent();
  team.each(2, [&](std::size_t) {  // one each: the caller's ends when the other has begun
    ++begun;
    while (begun < 2) std::this_thread::sleep_for(1ms);
    if (std::this_thread::get_id() != caller) std::this_thread::sleep_for(2s);
  });
  CHECK(spent() - before < 0.5);
}

namespace {

/// Runs of work whose time alone is 1 (in units of `unit` s) for some seconds; what they took, over what they take
/// alone. `helped`: time of the n-th run with help.
template <class F>
double slowness(Habit& habit, double unit, double seconds, F&& helped) {
  double took = 0, alone = 0;
  for (std::uint64_t n = 0; took < seconds; ++n) {
    const double now = unit * (habit.helped() ? helped(n) : 1);
    took += now, alone += unit;
    habit.note(now, 1000);
  }
  return took / alone;
}

}  // namespace

TEST_CASE("help is taken where it pays, left where it does not, and asked for again when the machine is quiet") {
  for (const double unit : {50e-6, 3e-3}) {
    Habit quiet, small, loaded;
    CHECK(slowness(quiet, unit, 10, [](auto) { return 0.55; }) < 0.55 + 0.45 / 50);
    CHECK(slowness(small, unit, 10, [](auto) { return 1.2; }) < 1.02);
    // Another program takes the core for 4 ms of each 8, and with it a piece that is waited for.
    const double slice = 4e-3 / unit;
    const auto every = static_cast<std::uint64_t>(std::ceil(slice / 0.55));
    const auto stalls = [&](std::uint64_t n) { return n % every == 0 ? 0.55 + slice : 0.55; };
    CHECK(slowness(loaded, unit, 10, stalls) < 1.1);
    CHECK(slowness(loaded, unit, 5, [](auto) { return 0.55; }) < 0.75);  // two seconds until it is tried again
    CHECK(slowness(loaded, unit, 10, [](auto) { return 0.55; }) < 0.57);
  }
}
