// SPDX-License-Identifier: LGPL-3.0-or-later
// What a run hears from the system, each case in a process of its own, and when it stops for its time.
#include "apps/run/signals.hpp"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <functional>
#include <thread>

#include "dem/base/error.hpp"
#include "tests/helpers.hpp"

using namespace grus;
using namespace grus::app;

namespace {

/// The status with which a process that does this ends; -signal where one has ended it.
int status_of(const std::function<int()>& act) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) _exit(act());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

/// Hears signals and sends itself these; 1 where it has been asked to stop, 2 to write a checkpoint.
int heard(
    const std::vector<int>& signals, const std::function<void()>& before = [] {}) {
  return status_of([&] {
    before();
    hear_signals();
    for (const int s : signals) raise(s);
    return (interruption_asked() ? 1 : 0) + (checkpoint_asked() ? 2 : 0);
  });
}

void wait(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

std::string refusal(const std::string& text) {
  try {
    duration_of("--max-time", text);
  } catch (const dem::InputError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("signals ask a run to stop or to write a checkpoint, and broken pipes and full disks are no signals") {
  CHECK(heard({}) == 0);
  for (const int stop : {SIGINT, SIGTERM, SIGHUP}) CHECK(heard({stop}) == 1);
  for (const int wish : {SIGUSR1, SIGUSR2}) CHECK(heard({wish}) == 2);
  CHECK(heard({SIGUSR2, SIGUSR2, SIGINT}) == 3);
  CHECK(heard({SIGPIPE, SIGXFSZ}) == 0);
}

TEST_CASE("a signal that was ignored from the start stays so, as nohup asks") {
  CHECK(heard({SIGHUP, SIGHUP}, [] { signal(SIGHUP, SIG_IGN); }) == 0);
  CHECK(heard({SIGHUP, SIGTERM}, [] { signal(SIGHUP, SIG_IGN); }) == 1);
}

TEST_CASE(
    "a second Ctrl-C ends the process at once, a second SIGTERM or SIGHUP where it comes a while after the first") {
  CHECK(heard({SIGINT, SIGINT}) == 128 + SIGINT);
  CHECK(heard({SIGTERM, SIGINT}) == 128 + SIGINT);
  CHECK(heard({SIGTERM, SIGTERM}) == 1);  // the same, told twice
  CHECK(heard({SIGINT, SIGHUP, SIGTERM}) == 1);
  CHECK(status_of([] {
          hear_signals();
          raise(SIGTERM), wait(2.1), raise(SIGTERM);
          return 0;
        }) == 128 + SIGTERM);
}

TEST_CASE("a checkpoint is asked for until it has been written, and again by the next signal") {
  CHECK(status_of([] {
          hear_signals();
          raise(SIGUSR1);
          const bool asked = checkpoint_asked();
          checkpoint_written();
          const bool done = !checkpoint_asked();
          raise(SIGUSR1);
          return asked && done && checkpoint_asked() ? 0 : 1;
        }) == 0);
}

TEST_CASE("what is being read when a signal comes is read on") {
  CHECK(status_of([] {
          int ends[2];
          if (pipe(ends) != 0) return 1;
          hear_signals();
          const pid_t parent = getpid(), child = fork();
          if (child == 0) {
            wait(0.05), kill(parent, SIGUSR1), wait(0.05);
            _exit(write(ends[1], "x", 1) == 1 ? 0 : 1);
          }
          char c = 0;
          const bool whole = read(ends[0], &c, 1) == 1 && c == 'x' && checkpoint_asked();
          waitpid(child, nullptr, 0);
          return whole ? 0 : 2;
        }) == 0);
}

TEST_CASE("of two reasons to stop the one that a user has given is told") {
  CHECK(stop_of(false) == Stop::none);
  CHECK(stop_of(true) == Stop::time);
  CHECK(status_of([] {
          hear_signals(), raise(SIGINT);
          return stop_of(true) == Stop::asked && stop_of(false) == Stop::asked ? 0 : 1;
        }) == 0);
}

TEST_CASE("a duration is a time with its unit or in seconds, above nothing") {
  CHECK(duration_of("", "90 min") == Approx(5400));
  CHECK(duration_of("", "2 h") == Approx(7200));
  CHECK(duration_of("", "1.5") == 1.5);
  CHECK(refusal("0 s") == "--max-time: must be above 0, given 0 s");
  CHECK(refusal("-1") == "--max-time: must be above 0, given -1");
  CHECK(refusal("3 m").find("--max-time: ") == 0);
  CHECK(refusal("3 m").find("(a time such as \"90 min\", \"2 h\" or \"3600 s\")") != std::string::npos);
}

TEST_CASE("the age of a process is counted from its start, not from the machine's") {
  CHECK(status_of([] {
          const double now = age_of_process();  // of clock ticks of 10 ms
          wait(0.2);
          const double later = age_of_process();
          return now >= 0 && now < 5 && later - now > 0.19 && later - now < 5 ? 0 : 1;
        }) == 0);
}

TEST_CASE("a run stops where its longest piece and the time for writing no longer fit") {
  const dem::Clock start;
  CHECK(!TimeLimit(start, 0).over(1e9));  // no limit
  CHECK(!TimeLimit(start, 0).past());
  // Two in a hundred for writing, but no less than a second and no more than a minute.
  for (const auto& [limit, writing] : {std::pair{1000.0, 20.0}, {10.0, 1.0}, {86400.0, 60.0}}) {
    const dem::Clock begin;
    TimeLimit t(begin, limit);
    wait(0.05);
    const double least = begin.wall();
    CHECK(!t.over(0));  // one piece
    const double most = begin.wall(), spare = 0.25 * writing;
    CHECK(!t.over((limit - writing - spare) / most));
    CHECK(t.over((limit - writing + spare) / least));
    CHECK(!t.over(0));  // a short piece: the longest counts
    CHECK(t.over((limit - writing + spare) / least));
    CHECK(!t.past());
  }
}

TEST_CASE("three times the longest writing is kept free at the end, and writing is no piece of the work") {
  const dem::Clock begin;
  TimeLimit t(begin, 1000);
  t.wrote(332);
  CHECK(!t.past());
  t.wrote(334);
  CHECK(t.past());
  t.wrote(1);
  CHECK(t.past());
  const dem::Clock again;
  TimeLimit w(again, 1000);
  wait(0.1);
  w.wrote(0.1);
  CHECK(!w.over(985 / 0.1));  // a thousand seconds and more, had these 0.1 s been a piece
}

TEST_CASE("of a short time a fifth is for writing") {
  const dem::Clock begin;
  const TimeLimit t(begin, 0.5);
  CHECK(!t.past());
  wait(0.45);  // 0.1 s are for writing
  CHECK(t.past());
}
