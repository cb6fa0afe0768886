// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/prepare_sample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "apps/scene/sample_scene.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"

namespace grus::app {
namespace {

/// A void ratio that differs by more than this from the packing's is told of.
constexpr double told_void_ratio = 0.01;

/// From the least to the largest of some samples.
struct Span {
  double low = INFINITY, high = -INFINITY;

  void add(double v) { low = std::min(low, v), high = std::max(high, v); }
  std::array<double, 2> pair() const { return {low, high}; }
  template <class Form>
  std::string text(Form form) const {
    const std::string first = form(low), last = form(high);
    return first == last ? first : first + " to " + last;
  }
};

/// Several that are told together.
struct Preparations {
  std::size_t count = 0;
  Span packed, now, pressure;
  double worst = 0;
  bool changed = false;  // a void ratio, by more than nobody would mind

  explicit Preparations(const std::vector<nlohmann::json>& told) {
    for (const auto& t : told)
      if (!t.is_null()) add(t);
  }
  void add(const nlohmann::json& t) {
    const double before = t.at("packed_void_ratio"), after = t.at("void_ratio");
    double asked = 0;
    for (const auto& stress : t.at("asked_stress_Pa")) asked += stress.get<double>() / 3;
    ++count, packed.add(before), now.add(after), pressure.add(asked);
    worst = std::max(worst, t.at("worst_stress_error").get<double>());
    changed = changed || (before > 1e-3 && std::abs(after - before) > told_void_ratio * before);
  }
};

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

nlohmann::json tell_preparation(const RveScene& cell, const dem::State& state,
                                const std::optional<dem::Vec3>& stresses) {
  if (!cell.preparation) return {};
  const dem::Measurement m = dem::measure(cell.model, state);
  const dem::Vec3 asked = stresses.value_or(dem::Vec3::Constant(cell.preparation->pressure)),
                  got = -m.stress.diagonal();
  const double packed = dem::bulk_volume(cell.state.boundary) / dem::solid_volume(cell.state.grains) - 1;
  // Cells of a rock leave no voids from the start: what is below 0 is their strain, or round-off.
  return {{"asked_stress_Pa", {asked.x(), asked.y(), asked.z()}},
          {"stress_Pa", {got.x(), got.y(), got.z()}},
          {"worst_stress_error", (got.array() / asked.array() - 1).abs().maxCoeff()},
          {"packed_void_ratio", std::max(0.0, packed)},
          {"void_ratio", std::max(0.0, m.void_ratio)}};
}

std::string note_of_preparations(const std::vector<nlohmann::json>& told) {
  const Preparations all(told);
  if (!all.changed) return {};
  const auto ratio = [](double e) { return fmt::format("{:.3f}", e); };
  const auto solid = [](double e) { return fmt::format("{:.4f}", 1 / (1 + e)); };
  return fmt::format(
      "preparation: the packing has a void ratio of {} (solid fraction {}); compressed to {} MPa the sample begins the "
      "test at {} ({}). A lower preparation.friction makes it denser, a higher one looser",
      all.packed.text(ratio), all.packed.text(solid),
      all.pressure.text([](double p) { return fmt::format("{:.3g}", p / 1e6); }), all.now.text(ratio),
      all.now.text(solid));
}

nlohmann::json sum_of_preparations(const std::vector<nlohmann::json>& told) {
  const Preparations all(told);
  if (all.count == 0) return {};
  return {{"starts", all.count},
          {"asked_pressure_Pa", all.pressure.pair()},
          {"packed_void_ratio", all.packed.pair()},
          {"void_ratio", all.now.pair()},
          {"worst_stress_error", all.worst}};
}

dem::State prepare_sample(RveScene& scene, dem::Team& team, const StageWatch& watch,
                          const std::optional<dem::Vec3>& stresses) {
  dem::State state = start_from(prepare_base(scene, team, watch), scene, team, watch, stresses);
  scene.prepared = tell_preparation(scene, state, stresses);
  if (const std::string note = note_of_preparations({scene.prepared}); !note.empty()) scene.notes.push_back(note);
  return state;
}

}  // namespace grus::app
