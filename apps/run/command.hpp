// SPDX-License-Identifier: LGPL-3.0-or-later
// Shared by all commands: options, results folder, progress line, interruption, exit status.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/run/run_log.hpp"
#include "apps/run/signals.hpp"
#include "dem/base/clock.hpp"

struct rusage;

namespace grus::app {

struct Options {
  std::string scene, directory;
  std::vector<std::string> overrides;
  int threads = 0;      // 0: all cores given
  double max_time = 0;  // s of wall time since `started`; 0: as long as it takes
  dem::Clock started;
  std::shared_ptr<Log> log;  // null: none
  bool check = false, columns = false, quiet = false, force = false, resume = false;
  bool speaks() const { return !quiet || log; }
};

inline constexpr int finished = 0, failed = 1, refused = 2, unstable = 3, out_of_time = 75, interrupted = 130;

/// Says it on the terminal, unless the run is to be quiet, and in its log. `text`: lines without the last line end.
void say(const Options& options, const std::string& text);
/// One line on standard error, and in the log.
void say_fault(const Options& options, const std::string& text);

/// Does on every rank what may fail on one of them; then it fails on all.
using Together = std::function<void(const std::function<void()>& part)>;

/// Parses the command line (prints help and version itself) and runs `work`; turns exceptions into one line and a
/// status. Of several ranks only one `speaks`; `sharers` of them share this one's cores.
int run_command(
    int argc, char** argv, const std::string& name, const std::string& description,
    const std::function<int(const Options&)>& work, bool speaks = true, int sharers = 1,
    const Together& together = [](const std::function<void()>& part) { part(); });

/// A message without line ends or other control characters, which texts of a scene may bring along.
std::string one_line(const std::string& text);

using dem::Clock;

/// CPU seconds of the process so far, all threads.
double cpu_seconds();
/// What the system has counted, of user and of system.
double cpu_seconds(const rusage& use);

/// One live line on a terminal; without, and under mpirun, which gives ranks a terminal whatever it writes to, a line
/// with the time of day every 5 % or 20 s. The same lines go into the log.
class Progress {
public:
  explicit Progress(const Options& options, bool quiet = false);
  /// `done` from 0 to 1; `text` says where things stand.
  void show(double done, const std::string& text);
  void finish(const std::string& text);
  /// A line that stays, above the live one.
  void note(const std::string& text);
  /// Shows the part of a stage of the work that is done, and hears interruptions and the end of the time: what a
  /// dem::Watch is to do. What is stopped has nothing to go on from.
  bool watch(double done, const std::string& what);

private:
  bool quiet_, terminal_;
  std::shared_ptr<Log> log_;
  Clock clock_;
  TimeLimit limit_;
  std::string stage_;
  double stage_began_ = 0, last_shown_ = -1, last_line_ = -1, last_part_ = -1, first_shown_ = 0, first_part_ = -1;
};

/// A table of numbers kept in memory and written whole, so that a reader never sees half a row.
class History {
public:
  History(std::string path, std::vector<std::string> columns);
  void add(const std::vector<double>& row);
  /// Brings the file up to date if the last time is longer ago than `seconds`: whole at first, then at its end.
  void save(double seconds = 0);
  /// Goes on from what was kept of an earlier part of the run.
  void restore(const std::string& text, std::size_t rows, const std::vector<double>& last = {});
  const std::string& text() const { return text_; }
  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<double>& last() const { return last_; }
  std::size_t rows() const { return rows_; }

private:
  std::string path_, text_;
  std::vector<std::string> columns_;
  std::vector<double> last_;
  std::size_t rows_ = 0, written_ = 0;
  Clock clock_;
  double saved_ = -1e9;
};

/// Version, compiler and machine facts for summary.json.
nlohmann::json provenance();

std::string default_directory(const std::string& scene);

/// 12.3 s, 4 min 05 s, 2 h 10 min.
std::string duration_text(double seconds);

}  // namespace grus::app
