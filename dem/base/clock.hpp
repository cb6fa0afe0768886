// SPDX-License-Identifier: LGPL-3.0-or-later
// Wall time, for what tells users where it went; no result depends on it.
#pragma once

#include <chrono>

namespace grus::dem {

/// Seconds since it was made.
class Clock {
public:
  double wall() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace grus::dem
