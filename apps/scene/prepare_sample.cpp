// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/prepare_sample.hpp"

#include <algorithm>

#include "apps/scene/sample_scene.hpp"
#include "dem/rve/step.hpp"

namespace grus::app {
namespace {

dem::Watch stage_of(const StageWatch& watch, const char* what) {
  return watch ? dem::Watch([&watch, what](double done) { return watch(done, what); }) : dem::Watch();
}

/// The model while a sample is compressed: the friction of `materials`, and enough damping to come to rest.
dem::Model compressing(dem::Model model) {
  dem::renew_friction(model);
  if (std::all_of(model.damping.begin(), model.damping.end(), [](double d) { return d == 0; }))
    dem::set_damping(model, 0.3);
  return model;
}

}  // namespace

dem::State prepare_base(RveScene& scene, dem::Team& team, const StageWatch& watch) {
  make_sample(scene, team, stage_of(watch, "packing"));
  dem::State state = scene.state;
  if (!scene.preparation) return state;
  dem::Model model = scene.model;  // the friction of the preparation, not of the test
  for (auto& m : model.materials)
    if (std::isfinite(m.youngs_modulus)) m.friction = scene.preparation->friction;
  model = compressing(std::move(model));
  dem::prepare(model, state, team);
  dem::compress_isotropically(model, scene.preparation->quasi_static, state, scene.preparation->pressure, team,
                              stage_of(watch, "preparation"));
  return state;
}

dem::State start_from(dem::State state, const RveScene& scene, dem::Team& team, const StageWatch& watch,
                      const std::optional<dem::Vec3>& stresses) {
  if (scene.preparation) {
    if (stresses) {
      const dem::Model model = compressing(scene.model);
      dem::prepare(model, state, team);
      dem::compress(model, scene.preparation->quasi_static, state, *stresses, team, stage_of(watch, "preparation"));
    }
    state.time = 0;
    state.steps = 0;
    state.ledger = {};
  }
  dem::prepare(scene.model, state, team);
  return state;
}

dem::State prepare_sample(RveScene& scene, dem::Team& team, const StageWatch& watch,
                          const std::optional<dem::Vec3>& stresses) {
  return start_from(prepare_base(scene, team, watch), scene, team, watch, stresses);
}

}  // namespace grus::app
