// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/base/parallel.hpp"

#include <algorithm>
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

Team::Team(int threads) {
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

void Team::run(Call call, void* context, std::size_t n) {
  call_ = call;
  context_ = context;
  n_ = n;
  pending_.store(static_cast<int>(workers_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  piece(0);
  for (int spins = 0; pending_.load(std::memory_order_acquire) > 0;) relax(spins);
}

void Team::work(int rank) {
  unsigned seen = 0;
  while (true) {
    for (int spins = 0, waits = 0; round_.load(std::memory_order_acquire) == seen;) {
      relax(spins);
      if (spins == 0 && ++waits > 200) round_.wait(seen, std::memory_order_acquire);  // idle between stages
    }
    ++seen;
    if (stop_) return;
    piece(rank);
    pending_.fetch_sub(1, std::memory_order_release);
  }
}

}  // namespace grus::dem
