// SPDX-License-Identifier: LGPL-3.0-or-later
// Signals that the system sends to a run, and how long the run may last.
#pragma once

#include <string>

#include "dem/base/clock.hpp"

namespace grus::app {

/// SIGINT, SIGTERM and SIGHUP ask a run to stop, SIGUSR1 and SIGUSR2 to write a checkpoint and go on; those that the
/// process was started with as ignored stay so (nohup). A full disk and a closed pipe are errors of a write, no
/// signals.
void hear_signals();

/// True once Ctrl-C, SIGTERM or SIGHUP has been heard; another one ends the process at once. mpirun and Slurm tell a
/// rank the same thing twice: a SIGTERM or SIGHUP within a second of the first is that one.
bool interruption_asked();

/// True from SIGUSR1 or SIGUSR2 until `checkpoint_written`.
bool checkpoint_asked();
void checkpoint_written();

/// Seconds of "90 min", "2 h" or a bare number. Throws InputError, which begins with `key`.
double duration_of(const std::string& key, const std::string& text);

/// Seconds since the process was started: MPI may have taken some of them.
double age_of_process();

/// Why a run stops before its end.
enum class Stop { none, asked, time };

/// Tells a run when to stop so that it is over, files written, before its time is.
class TimeLimit {
public:
  /// `limit`: s of wall time since `start`; 0: none.
  TimeLimit(const dem::Clock& start, double limit);

  /// Asked between pieces of the work. True where `pieces` as long as the longest so far no longer fit.
  bool over(double pieces = 1);
  /// Asked in the middle of a piece: true where only the time for writing is left.
  bool past() const;
  /// Writing has taken this long (s): it is no piece of the work, and is left time for at the end.
  void wrote(double seconds);

private:
  double writing() const;
  const dem::Clock& start_;
  double limit_, last_, piece_ = 0, longest_write_ = 0;
};

/// Whether to stop, and why; of two reasons the one that a user has given.
Stop stop_of(bool over);

}  // namespace grus::app
