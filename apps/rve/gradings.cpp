// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/gradings.hpp"

#include <fmt/format.h>

#include <cmath>

#include "apps/run/folder.hpp"
#include "dem/io/whole_file.hpp"
#include "dem/rve/grading.hpp"

namespace grus::app {
namespace {

constexpr std::size_t classes = 40;
constexpr double span = 8;  // of the first smallest grain over the smallest class

}  // namespace

GradingStates::GradingStates(const std::string& directory, const RveScene& scene, const dem::State& start)
    : directory_(directory), scene_(scene) {
  if (scene.output.gradings == 0) return;
  const dem::Grading first(start);
  largest_ = first.largest() * (1 + 1e-9), smallest_ = first.smallest() / span;
  text_ = "time_s,strain,diameter_m,passing,grains,mass_kg,coordination,elongation,flatness,generation\n";
}

void GradingStates::write_if_due(const dem::State& state, double at, double strain) {
  const int states = scene_.output.gradings;
  const double every = states > 1 ? scene_.test.duration / (states - 1) : scene_.test.duration;
  if (written_ < states && at >= every * written_ * (1 - 1e-9)) write(state, strain);
}

void GradingStates::write_last(const dem::State& state, double strain) {
  if (written_ < scene_.output.gradings && state.time > last_) write(state, strain);
}

void GradingStates::write(const dem::State& state, double strain) {
  const dem::Grading now(state);
  const double told = std::round(1e12 * strain) / 1e12 + 0.0;  // round-off of a sample at rest is none
  for (const auto& c : dem::size_classes(state, smallest_, largest_, classes))
    text_ += fmt::format("{:.9g},{:.9g},{:.6g},{:.9g},{},{:.9g},{:.6g},{:.6g},{:.6g},{:.6g}\n", state.time, told,
                         c.upper / scene_.scale, now.passing(c.upper), c.grains, c.mass, c.coordination, c.elongation,
                         c.flatness, c.generation);
  dem::write_whole(result_file(directory_, "grading.csv"), text_);
  ++written_, last_ = state.time;
}

}  // namespace grus::app
