// SPDX-License-Identifier: LGPL-3.0-or-later
// A team of threads for loops over grains and contacts. Ranges are cut at fixed blocks, and every
// reduction is kept per block: the same bits for any number of threads. Who has not begun when the caller is done is
// not waited for: another program may hold its core.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "dem/base/habit.hpp"

namespace grus::dem {

inline constexpr std::size_t block_size = 128;
inline std::size_t block_count(std::size_t n) { return (n + block_size - 1) / block_size; }

/// One turn of waiting for another thread; now and then gives the core away.
void relax(int& spins);

class Team {
public:
  /// Throws std::runtime_error where the system does not give that many threads.
  explicit Team(int threads = 1);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls f(begin, end) for pieces of [0, n) that start at multiples of block_size; returns when all are done.
  template <class F>
  void blocks(std::size_t n, F&& f) {
    if (workers_.empty() || n <= 2 * block_size) {
      if (n > 0) f(std::size_t{0}, n);
      return;
    }
    run([](void* context, std::size_t b, std::size_t e) { (*static_cast<std::remove_reference_t<F>*>(context))(b, e); },
        &f, n, n);
  }

  /// Calls f(begin, end, rank) for one piece of [0, n) a thread; returns when all are done. `load`: n + 1 running sums
  /// of what each index costs, so that the pieces cost the same; empty: the same number each.
  template <class F>
  void pieces(std::size_t n, std::span<const std::uint64_t> load, F&& f) {
    if (workers_.empty() || n < 2) {
      if (n > 0) f(std::size_t{0}, n, 0);
      return;
    }
    const std::size_t all = static_cast<std::size_t>(threads());
    auto cut = [&](std::size_t rank) {
      if (load.empty()) return n * rank / all;
      const std::uint64_t share = load[n] / all * rank;
      return rank == all ? n
                         : static_cast<std::size_t>(std::lower_bound(load.begin(), load.end(), share) - load.begin());
    };
    auto piece = [&](std::size_t b, std::size_t) {
      const std::size_t rank = b / block_size, begin = cut(rank), end = cut(rank + 1);
      if (begin < end) f(begin, end, static_cast<int>(rank));
    };
    run([](void* context, std::size_t b, std::size_t e) { (*static_cast<decltype(piece)*>(context))(b, e); }, &piece,
        all * block_size, n);
  }
  template <class F>
  void pieces(std::size_t n, F&& f) {
    pieces(n, {}, f);
  }

  /// Calls f(i) or f(i, rank) for i in [0, n), handed out one by one: for few, long and uneven jobs. No two calls of
  /// one rank at a time.
  template <class F>
  void each(std::size_t n, F&& f) {
    std::atomic<std::size_t> next{0};
    auto take = [&](std::size_t b, std::size_t) {
      for (std::size_t i = next++; i < n; i = next++) {
        if constexpr (std::is_invocable_v<F, std::size_t, std::size_t>)
          f(i, b / block_size);
        else
          f(i);
      }
    };
    if (workers_.empty() || n < 2) return take(0, 0);
    run([](void* context, std::size_t b, std::size_t e) { (*static_cast<decltype(take)*>(context))(b, e); }, &take,
        block_size * static_cast<std::size_t>(threads()), 0);
  }

private:
  using Call = void (*)(void*, std::size_t, std::size_t);
  /// `work`: how much it is, if it is the same work every time; 0: who knows.
  void run(Call call, void* context, std::size_t n, std::size_t work);
  void run_alone();
  void run_helped();
  Habit& habit_of(Call call);
  void piece(int rank) const;
  void work(int rank);
  void send_home();

  std::vector<std::thread> workers_;
  Call call_ = nullptr;
  void* context_ = nullptr;
  std::size_t n_ = 0;
  alignas(64) std::atomic<std::uint64_t> round_{0};
  /// Each worker's state: 4 x round, and how far its piece of that round is.
  struct alignas(64) Seat {
    static constexpr std::uint64_t open = 0, taken = 1, done = 2;
    std::atomic<std::uint64_t> state{done};
  };
  std::unique_ptr<Seat[]> seats_;
  std::atomic<bool> stop_{false};
  std::vector<std::pair<Call, Habit>> habits_;
};

}  // namespace grus::dem
