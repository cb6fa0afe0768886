// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/row.hpp"

#include <algorithm>

#include "dem/rve/wall_force.hpp"
#include "dem/sample/gauge.hpp"
#include "dem/sample/strain_gauges.hpp"

namespace grus::app {

Row::Row(const RveScene& of, const dem::Sample& sample, const FirstGrains& grains, const dem::State& now,
         const dem::Measurement& m, const dem::Mat3& began)
    : scene(of),
      first(sample.state),
      first_grains(grains),
      state(now),
      measured(m),
      gradient(dem::displacement_gradient(now, of.test.loading, began)),
      initial_cell(began) {}

const dem::Mat3& Row::sample_stress() const { return dem::sample_stress(state, measured); }

const dem::Grading& Row::grading() const {
  return grading_([&] { return dem::Grading(state, scene.scale); });
}

const dem::Zingg& Row::zingg() const {
  return zingg_([&] { return dem::zingg(state.grains); });
}

const dem::Roundness& Row::roundness() const {
  return roundness_([&] { return dem::roundness(state.grains); });
}

const dem::Fragments& Row::fragments() const {
  return fragments_([&] { return dem::fragments_of(state); });
}

const dem::AddedInertia& Row::added() const {
  return added_([&] { return dem::added_inertia(state.grains); });
}

const dem::CriticalGrain& Row::critical() const {
  return critical_([&] { return dem::critical_grain(scene.model, state); });
}

const dem::Vec3& Row::wall_force(std::size_t wall) const {
  return wall_forces_([&] {
    std::vector<dem::Vec3> all;
    for (std::size_t w = 0; w < state.boundary.walls.size(); ++w) all.push_back(dem::wall_force(state, w));
    return all;
  })[wall];
}

const std::array<double, 2>& Row::face_stresses() const {
  return faces_([&] { return dem::face_stresses(scene.test, first, state); });
}

const dem::Mat3& Row::gauged() const {
  return gauged_([&] { return dem::gauged_gradient(first, state, scene.test.axis); });
}

double Row::load() const {
  return load_([&] { return dem::load_of(*scene.test.gauge, state); });
}

std::optional<std::size_t> Row::grain(std::size_t id) const {
  return grains_([&] {
    std::vector<std::optional<std::size_t>> places(listed_of(scene));
    for (std::size_t i = 0; i < state.grains.size(); ++i)
      if (state.grains.id[i] < places.size()) places[state.grains.id[i]] = i;
    return places;
  })[id];
}

}  // namespace grus::app
