// SPDX-License-Identifier: LGPL-3.0-or-later
// What a run asks later of its grains as they were made, so that these need not stand beside its own.
#pragma once

#include <optional>

#include "apps/scene/rve_scene.hpp"
#include "dem/rve/grading.hpp"
#include "dem/sample/make.hpp"

namespace grus::app {

struct FirstGrains {
  std::size_t count;
  double mass;                               // kg
  std::optional<dem::Grading> grading = {};  // with output.grading
};

/// Takes that from a sample and lets its grains go; strain gauges need their places and numbers.
inline FirstGrains take_first(const RveScene& scene, dem::Sample& sample) {
  dem::Grains& g = sample.state.grains;
  FirstGrains first{g.size(), dem::total_mass(g)};
  if (scene.output.grading) first.grading.emplace(sample.state, scene.scale);
  dem::Grains gauged;
  if (scene.output.strain_gauges) gauged.motion = std::move(g.motion), gauged.id = std::move(g.id);
  g = std::move(gauged);
  return first;
}

}  // namespace grus::app
