// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/prepare_sample.hpp"

#include <algorithm>

#include "apps/scene/sample_scene.hpp"
#include "dem/rve/step.hpp"

namespace grus::app {

dem::State prepare_sample(RveScene& scene, dem::Team& team, const StageWatch& watch,
                          const std::optional<dem::Vec3>& stresses) {
  auto stage = [&](const char* what) {
    return watch ? dem::Watch([&watch, what](double done) { return watch(done, what); }) : dem::Watch();
  };
  make_sample(scene, team, stage("packing"));
  dem::State state = scene.state;
  if (scene.preparation) {
    const auto make_laws = [](dem::Model& of) {
      dem::renew_friction(of);
      if (std::all_of(of.damping.begin(), of.damping.end(), [](double d) { return d == 0; }))
        dem::set_damping(of, 0.3);  // a sample must come to rest
    };
    dem::Model model = scene.model;  // the friction of the preparation, not of the test
    for (auto& m : model.materials)
      if (std::isfinite(m.youngs_modulus)) m.friction = scene.preparation->friction;
    make_laws(model);
    dem::prepare(model, state, team);
    dem::compress_isotropically(model, scene.preparation->quasi_static, state, scene.preparation->pressure, team,
                                stage("preparation"));
    if (stresses) {
      model.materials = scene.model.materials;
      make_laws(model);
      dem::prepare(model, state, team);
      dem::compress(model, scene.preparation->quasi_static, state, *stresses, team, stage("preparation"));
    }
    state.time = 0;
    state.steps = 0;
    state.ledger = {};
  }
  dem::prepare(scene.model, state, team);
  return state;
}

}  // namespace grus::app
