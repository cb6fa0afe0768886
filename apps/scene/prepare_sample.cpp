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

}  // namespace

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
    note_preparation(scene, dem::measure(model, state), stresses);
    state.time = 0;
    state.steps = 0;
    state.ledger = {};
    state.grain_steps = 0;
  }
  dem::prepare(scene.model, state, team);
  return state;
}

}  // namespace grus::app
