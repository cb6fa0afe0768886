// SPDX-License-Identifier: LGPL-3.0-or-later
// grading.csv: what the grains of each size are like, at evenly spaced states of the test.
#pragma once

#include <string>

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

class GradingStates {
public:
  /// `start`: the sample as it was made. Nothing is written unless the scene's output.gradings asks for states.
  GradingStates(const std::string& directory, const RveScene& scene, const dem::State& start);
  /// `at`: how far the test is, as a time of its duration (s); `strain`: along its axis, compression-positive.
  void write_if_due(const dem::State& state, double at, double strain);
  /// The state in which a test ends before its time: the stress is reached, or it is unstable.
  void write_last(const dem::State& state, double strain);

  /// For checkpoints: what was written so far.
  const std::string& text() const { return text_; }
  int written() const { return written_; }
  void restore(const std::string& text, int written) { text_ = text, written_ = written; }

private:
  void write(const dem::State& state, double strain);

  std::string directory_, text_;
  const RveScene& scene_;
  double smallest_ = 0, largest_ = 0;
  int written_ = 0;
  double last_ = -1;  // s, the time of the last one of this run
};

}  // namespace grus::app
