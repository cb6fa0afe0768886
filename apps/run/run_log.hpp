// SPDX-License-Identifier: LGPL-3.0-or-later
// --log FILE: what a program says, with the time of day, at the end of a file.
#pragma once

#include <string>
#include <string_view>

namespace grus::app {

/// 2026-11-25 18:52:13, local time.
std::string time_of_day();

class Log {
public:
  /// Throws InputError where no such file can be opened. One that is to lie in the results folder `waits_for`, whether
  /// that is there or not, is kept back until `begin`: a folder is made by a run, not by its log.
  Log(std::string path, const std::string& waits_for);
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void begin();
  /// Every line of the text with the time; a log that cannot be written stops nobody.
  void add(std::string_view text);

private:
  void write();
  std::string path_, text_;
  int file_ = -1;
};

}  // namespace grus::app
