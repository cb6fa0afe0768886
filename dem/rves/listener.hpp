// SPDX-License-Identifier: LGPL-3.0-or-later
// How tasks on several threads hear that they are to stop, though only the calling thread may be asked.
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <thread>

#include "dem/base/clock.hpp"
#include "dem/base/watch.hpp"

namespace grus::dem {

/// The thread that made it asks the watch, before each of its tasks and some times a second; all threads hear of it.
class Listener {
public:
  Listener(const Watch& watch, std::size_t tasks) : watch_(watch), tasks_(static_cast<double>(tasks)) {
    if (watch_)
      told_ = [this] {
        ask_at_times();
        obey();
      };
  }

  bool calling() const { return watch_ && std::this_thread::get_id() == caller_; }
  bool stopped() const { return stopped_; }
  /// Long work within a task calls it: throws Interrupted where it is to stop. Empty where nobody watches.
  const std::function<void()>& told() const { return told_; }

  void next_task() {
    const std::size_t before = begun_++;
    if (!calling()) return obey();
    if (!stopped_) ask(static_cast<double>(before) / tasks_);
    obey();
  }

  void ask_at_times() {
    if (calling() && !stopped_ && clock_.wall() - last_ > 0.05) ask(static_cast<double>(begun_) / tasks_);
  }

private:
  void ask(double part) {
    last_ = clock_.wall();
    stopped_ = !watch_(std::min(part, 1.0));
  }
  void obey() const {
    if (stopped_) throw Interrupted("interrupted");
  }

  const Watch& watch_;
  const double tasks_;
  const std::thread::id caller_ = std::this_thread::get_id();
  const Clock clock_;
  double last_ = 0;  // when it was asked (s)
  std::function<void()> told_;
  std::atomic<std::size_t> begun_{0};
  std::atomic<bool> stopped_{false};
};

}  // namespace grus::dem
