// SPDX-License-Identifier: LGPL-3.0-or-later
// Passes that a scene adds to a step beyond contacts and motion, as a short list: empty where the scene names nothing.
// A new pass is a row in passes.cpp; the step loop knows none by name.
#pragma once

#include <array>

#include "dem/rve/breakage.hpp"
#include "dem/rve/model.hpp"
#include "dem/rve/reshape.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// A step as the passes see it, with the room that they keep from step to step of a run.
struct Step {
  const Model& model;
  State& state;
  Team& team;
  double dt;
  bool again = false;   // grains.force and torque hold what the passes of the step before have left there, nothing else
  bool pulled = false;  // to be set by a pass that has left forces there
  Reshaping reshaping = {};
  std::vector<Break> breaks = {};
};

/// Entries that a pass does without are null.
struct Pass {
  bool (*wanted)(const Model& model, const State& state) = nullptr;  // once a run
  bool indexes = false;                                              // looks at contacts by grain
  bool shows = false;                                                // looks at contacts in every step
  void (*prepare)(const Model& model, State& state) = nullptr;       // before the first run
  void (*before_forces)(Step& step) = nullptr;                       // positions are new, forces are not
  void (*after_forces)(Step& step) = nullptr;
  bool (*due)(const State& state) = nullptr;  // whether `stops` is to be asked at the end of the step to come
  bool (*stops)(Step& step) = nullptr;        // true: the run ends with this step, and with `conclude`
  void (*conclude)(Step& step) = nullptr;
};

/// The passes that a scene wants, in their order.
class PassList {
public:
  void add(const Pass* pass) { pass_[size_++] = pass; }
  const Pass* const* begin() const { return pass_.data(); }
  const Pass* const* end() const { return pass_.data() + size_; }

  bool indexes() const;
  bool shows() const;
  bool due(const State& state) const;

private:
  std::array<const Pass*, 8> pass_{};
  std::size_t size_ = 0;
};

PassList passes_of(const Model& model, const State& state);

}  // namespace grus::dem
