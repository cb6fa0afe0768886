// SPDX-License-Identifier: LGPL-3.0-or-later
// Whether the help of other threads pays, as measured: small work is slower when it is shared, and so is any where
// another program holds the cores. Results never depend on it.
#pragma once

#include <algorithm>

namespace grus::dem {

/// One kind of work, done again and again. Times are per index of its range (s).
class Habit {
public:
  bool helped() const { return helped_; }

  /// Notes what a run over n indices took (s).
  void note(double seconds, double n) {
    time_ += seconds, work_ += n;
    if (++runs_ < (helped_ ? 64 : 16) && time_ < longest_look) return;
    const double mean = time_ / work_, looked = time_;
    time_ = work_ = 0, runs_ = 0;
    if (!helped_) {
      alone_ = mean;
      helped_ = --looks_ <= 0;
    } else if (alone_ == 0 || ++since_ == 64) {  // how long it takes alone is not known, or no longer
      since_ = 0, helped_ = false, looks_ = 1;
    } else if (mean > 0.98 * alone_) {
      helped_ = false, looks_ = rest_;
      rest_ = std::clamp(2 * rest_, 1, std::max(1, static_cast<int>(longest_rest / looked)));
    } else {
      rest_ = std::max(1, rest_ / 2);
    }
  }

private:
  static constexpr double longest_look = 0.03, longest_rest = 2;  // s

  bool helped_ = true;
  double alone_ = 0;
  double time_ = 0, work_ = 0;  // of this look
  int runs_ = 0;
  int looks_ = 0, rest_ = 1;  // alone: still to come, after the next disappointment
  int since_ = 0;             // looks with help since the last one alone
};

}  // namespace grus::dem
