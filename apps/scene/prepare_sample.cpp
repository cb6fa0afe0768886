// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/prepare_sample.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scene/sample_scene.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"

namespace grus::app {
namespace {

/// A void ratio that differs by more than this from the packing's is told of.
constexpr double told_void_ratio = 0.01;

/// What the preparation has made of the packing: its stresses, and a void ratio that nobody asked for.
void note_preparation(RveScene& scene, const dem::Measurement& m, const std::optional<dem::Vec3>& stresses) {
  const dem::Vec3 asked = stresses.value_or(dem::Vec3::Constant(scene.preparation->pressure)),
                  got = -m.stress.diagonal();
  const double packed =
      m.volume > 0 ? dem::bulk_volume(scene.state.boundary) / dem::solid_volume(scene.state.grains) - 1 : 0;
  scene.prepared = {{"asked_stress_Pa", {asked.x(), asked.y(), asked.z()}},
                    {"stress_Pa", {got.x(), got.y(), got.z()}},
                    {"worst_stress_error", (got.array() / asked.array() - 1).abs().maxCoeff()},
                    {"packed_void_ratio", packed},
                    {"void_ratio", m.void_ratio}};
  if (std::abs(m.void_ratio - packed) > told_void_ratio * packed)
    scene.notes.push_back(
        fmt::format("preparation: the packing has a void ratio of {:.3f} (solid fraction {:.4f}); compressed to {:.3g} "
                    "MPa the sample begins the test at {:.3f} ({:.4f}). A lower preparation.friction makes it denser, "
                    "a higher one looser",
                    packed, 1 / (1 + packed), asked.mean() / 1e6, m.void_ratio, m.solid_fraction));
}

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
    state.grain_steps = 0;
  }
  dem::prepare(scene.model, state, team);
  return state;
}

dem::State prepare_sample(RveScene& scene, dem::Team& team, const StageWatch& watch,
                          const std::optional<dem::Vec3>& stresses) {
  dem::State state = start_from(prepare_base(scene, team, watch), scene, team, watch, stresses);
  if (scene.preparation) note_preparation(scene, dem::measure(scene.model, state), stresses);
  return state;
}

}  // namespace grus::app
