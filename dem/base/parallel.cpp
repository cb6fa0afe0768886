// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/base/parallel.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <string>
#include <system_error>

namespace grus::dem {

void relax(int& spins) {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
  if (++spins > 4000) {  // some tens of microseconds: longer than a step's pause, shorter than a time slice
    spins = 0;
    std::this_thread::yield();
  }
}

namespace {

/// Sleeps after some milliseconds: others may need the core, and what one waits for may take long.
void wait_while(const std::atomic<std::uint64_t>& of, std::uint64_t value) {
  for (int spins = 0, waits = 0; of.load(std::memory_order_acquire) == value;) {
    relax(spins);
    if (spins == 0 && ++waits > 50) of.wait(value, std::memory_order_acquire);
  }
}

}  // namespace

Team::Team(int threads) : seats_(std::make_unique<Seat[]>(static_cast<std::size_t>(std::max(threads, 1)))) {
  habits_.reserve(32);  // of all kinds of work there are some fifteen
  try {
    for (int rank = 1; rank < threads; ++rank) workers_.emplace_back([this, rank] { work(rank); });
  } catch (const std::system_error& e) {
    const std::size_t made = workers_.size() + 1;
    send_home();
    throw std::runtime_error("cannot start " + std::to_string(threads) + " threads, only " + std::to_string(made) +
                             ": lower --threads (" + e.code().message() + ")");
  }
}

Team::~Team() { send_home(); }

void Team::send_home() {
  stop_ = true;
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (auto& worker : workers_) worker.join();
}

void Team::piece(int rank) const {
  const std::size_t blocks = block_count(n_), all = static_cast<std::size_t>(threads()),
                    r = static_cast<std::size_t>(rank);
  const std::size_t begin = blocks * r / all * block_size, end = std::min(n_, blocks * (r + 1) / all * block_size);
  if (begin < end) call_(context_, begin, end);
}

Habit& Team::habit_of(Call call) {
  for (auto& [known, habit] : habits_)
    if (known == call) return habit;
  return habits_.emplace_back(call, Habit{}).second;
}

void Team::run(Call call, void* context, std::size_t n, std::size_t work) {
  call_ = call, context_ = context, n_ = n;
  if (work == 0) return run_helped();
  using Clock = std::chrono::steady_clock;
  Habit& habit = habit_of(call);
  const auto begin = Clock::now();
  if (habit.helped())
    run_helped();
  else
    run_alone();
  habit.note(std::chrono::duration<double>(Clock::now() - begin).count(), static_cast<double>(work));
}

void Team::run_alone() {
  for (int rank = 0; rank < threads(); ++rank) piece(rank);
}

void Team::run_helped() {
  const std::uint64_t round = 4 * (round_.load(std::memory_order_relaxed) + 1);
  const std::size_t others = workers_.size();
  for (std::size_t k = 0; k < others; ++k) seats_[k].state.store(round + Seat::open, std::memory_order_release);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  piece(0);
  for (std::size_t k = 0; k < others; ++k) {
    auto& state = seats_[k].state;
    std::uint64_t open = round + Seat::open;
    if (state.compare_exchange_strong(open, round + Seat::done, std::memory_order_acquire))
      piece(static_cast<int>(k) + 1);  // it has not come
    else
      wait_while(state, round + Seat::taken);
  }
}

void Team::work(int rank) {
  auto& state = seats_[static_cast<std::size_t>(rank) - 1].state;
  std::uint64_t seen = 0;
  while (true) {
    wait_while(round_, seen);
    seen = round_.load(std::memory_order_acquire);
    if (stop_) return;
    std::uint64_t open = 4 * seen + Seat::open;
    if (!state.compare_exchange_strong(open, 4 * seen + Seat::taken, std::memory_order_acquire)) continue;
    piece(rank);
    state.store(4 * seen + Seat::done, std::memory_order_release);
    state.notify_one();
  }
}

}  // namespace grus::dem
