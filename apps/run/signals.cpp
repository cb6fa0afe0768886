// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/run/signals.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "apps/scene/units.hpp"
#include "dem/base/error.hpp"

namespace grus::app {
namespace {

volatile std::sig_atomic_t asked = 0, wanted = 0;
volatile std::sig_atomic_t first_second = 0;  // of the first request: of a clock that runs on

std::sig_atomic_t now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::sig_atomic_t>(t.tv_sec & 0x3fffffff);
}

void on_stop(int signal) {
  if (asked && (signal == SIGINT || now() - first_second > 1)) std::_Exit(128 + signal);
  if (!asked) first_second = now();
  asked = 1;
}

void on_wish(int) { wanted = 1; }

void hear(int signal, void (*handler)(int)) {
  struct sigaction before {};
  if (sigaction(signal, nullptr, &before) != 0 || before.sa_handler == SIG_IGN) return;
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

void hear_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) hear(signal, on_stop);
  for (const int signal : {SIGUSR1, SIGUSR2}) hear(signal, on_wish);
  for (const int signal : {SIGXFSZ, SIGPIPE}) hear(signal, SIG_IGN);
}

bool interruption_asked() { return asked != 0; }
bool checkpoint_asked() { return wanted != 0; }
void checkpoint_written() { wanted = 0; }

double duration_of(const std::string& key, const std::string& text) {
  double seconds = 0;
  try {
    seconds = parse_quantity(text, dimension::time).value;
  } catch (const std::invalid_argument& e) {
    throw dem::InputError(fmt::format("{}: {} (a time such as \"90 min\", \"2 h\" or \"3600 s\")", key, e.what()));
  }
  if (!(seconds > 0) || !std::isfinite(seconds))
    throw dem::InputError(fmt::format("{}: must be above 0, given {}", key, text));
  return seconds;
}

double age_of_process() {
  std::ifstream in("/proc/self/stat");
  std::string text{std::istreambuf_iterator<char>(in), {}};
  std::istringstream rest(text.substr(std::min(text.rfind(')') + 1, text.size())));  // a name may hold anything
  std::string field;
  for (int k = 3; k <= 22; ++k) rest >> field;  // 22: ticks from the start of the machine to that of the process
  const double begin = std::strtod(field.c_str(), nullptr) / static_cast<double>(sysconf(_SC_CLK_TCK));
  timespec time{};
  if (!rest || clock_gettime(CLOCK_BOOTTIME, &time) != 0) return 0;
  return std::max(0.0, static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec) - begin);
}

TimeLimit::TimeLimit(const dem::Clock& start, double limit)
    : start_(start), limit_(limit > 0 ? limit : INFINITY), last_(start.wall()) {}

/// At first 2 % of the time, as far as that is between a second and a minute; then three times what writing has taken:
/// the disk of a cluster is shared.
double TimeLimit::writing() const {
  return std::max(std::clamp(0.02 * limit_, std::min(1.0, 0.2 * limit_), 60.0), 3 * longest_write_);
}

bool TimeLimit::over(double pieces) {
  const double time = start_.wall();
  piece_ = std::max(piece_, time - last_), last_ = time;
  return time + pieces * piece_ + writing() > limit_;
}

bool TimeLimit::past() const { return start_.wall() + writing() > limit_; }

void TimeLimit::wrote(double seconds) { longest_write_ = std::max(longest_write_, seconds), last_ = start_.wall(); }

Stop stop_of(bool over) { return interruption_asked() ? Stop::asked : over ? Stop::time : Stop::none; }

}  // namespace grus::app
