// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/prepare_sample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "apps/scene/engine_scene.hpp"
#include "apps/scene/speeds.hpp"
#include "apps/scene/stage_scene.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/stepper.hpp"

namespace grus::app {
namespace {

/// No step that grains are given the inertia for is longer than so many times a wave takes through one.
constexpr double most_step_of_wave = 1000;

/// Tests up to this inertial number are slow enough for added inertia not to matter.
constexpr double most_slow_inertia = 0.01;

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
  Span packed, now, pressure, asked, friction;  // the last two where a void ratio was asked for
  int tries = 0;                                // of a packing, the most
  double worst = 0;
  bool changed = false;  // a void ratio, by more than nobody would mind

  explicit Preparations(const std::vector<nlohmann::json>& told) {
    for (const auto& t : told)
      if (!t.is_null()) add(t);
  }
  void add(const nlohmann::json& t) {
    const double before = t.at("packed_void_ratio"), after = t.at("void_ratio");
    double stress = 0;
    for (const auto& s : t.at("asked_stress_Pa")) stress += s.get<double>() / 3;
    ++count, packed.add(before), now.add(after), pressure.add(stress);
    if (t.contains("asked_void_ratio")) {
      asked.add(t.at("asked_void_ratio")), friction.add(t.at("friction"));
      tries = std::max(tries, t.at("tries").get<int>());
    }
    worst = std::max(worst, t.at("worst_stress_error").get<double>());
    changed = changed || (before > 1e-3 && std::abs(after - before) > told_void_ratio * before);
  }
};

/// A step for which next to nothing but added inertia would resist: far beyond what a wave takes through any grain.
void refuse_long_step(const RveScene& scene, const dem::Grains& grains) {
  const double step = scene.model.numerics.inertia_step;
  double largest = 0;
  for (const dem::Extent& e : grains.extent) largest = std::max(largest, 2 * e.equivalent_radius);
  const double wave = largest / fastest_wave(scene.model);
  if (step > most_step_of_wave * wave)
    dem::refuse(
        scene.model.numerics.place_of_step,
        fmt::format("{:.4g} s: {:.2g} times what a wave takes through the largest grain; at {:.2g} times, hardly "
                    "anything but the added inertia would move: ask for less than {:.2g} s",
                    step, step / wave, most_step_of_wave, most_step_of_wave * wave));
}

/// Fines of no grain at the start could be as large as the smallest are to be.
void refuse_large_fines(const RveScene& scene, const dem::Grains& grains) {
  std::vector<double> largest(scene.model.materials.size());  // m
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const double radius = grains.extent.empty() ? grains.motion[i].radius : grains.extent[i].equivalent_radius;
    largest[grains.material[i]] = std::max(largest[grains.material[i]], 2 * radius);
  }
  for (std::size_t m = 0; m < largest.size(); ++m) {
    const auto& fracture = scene.model.materials[m].fracture;
    if (!fracture || largest[m] == 0) continue;
    const dem::FinesGrading& fines = fracture->fines;
    const double top = fines.largest * largest[m];
    if (fines.smallest >= top)
      dem::refuse(fmt::format("{}: material.{}.fracture.fines.smallest", scene.file, scene.model.materials[m].name),
                  fmt::format("{:.4g} m: the largest fines of the largest grain have {:.4g} m (largest = {:.3g} of its "
                              "diameter); ask for less than that",
                              fines.smallest, top, fines.largest));
  }
}

/// The rate (1/s) at which a test leaves the preparation's pressure; 0 where its rate is a limit alone: it is then as
/// slow as its stress asks. Of stages the first that moves decides: what pressure the next ones meet is not known.
double first_rate(const dem::Programme& test) {
  using Kind = dem::TestKind;
  if (test.kind == Kind::staged) {
    const auto moves = [](const dem::Stage& s) { return s.strain_rate != 0; };
    const auto first = std::find_if(test.stages.begin(), test.stages.end(), moves);
    return first != test.stages.end() && first->by_strain() ? first->strain_rate : 0;
  }
  const bool at_rate = test.kind == Kind::uniaxial_strain || test.kind == Kind::triaxial ||
                       test.kind == Kind::constant_p || test.kind == Kind::true_triaxial ||
                       test.kind == Kind::velocity_gradient;
  return at_rate ? test.strain_rate : 0;
}

/// Inertia that is added changes what a test at such a rate, begun at the preparation's pressure, finds: a test of a
/// split-Hopkinson bar.
void refuse_real_time(const RveScene& scene, const dem::State& packed) {
  const double rate = first_rate(scene.test);
  if (rate == 0 || !scene.recipe.preparation) return;
  const double pressure = scene.recipe.preparation->pressure;
  const double inertia = dem::inertial_number(packed, rate, pressure);
  const bool by_step = scene.model.numerics.inertia_step > 0;
  if (inertia > most_slow_inertia)
    dem::refuse(scene.model.numerics.place_of_step,
                fmt::format("is for slow tests: {:.3g} 1/s at {:.3g} Pa is an inertial number of {:.2g}, above {:g}; "
                            "time is real there, leave {} out",
                            std::abs(rate), pressure, inertia, most_slow_inertia, by_step ? "inertia.step" : "engine"));
}

}  // namespace

std::optional<dem::Sample> made_at_once(const RveScene& scene) {
  if (scene.recipe.random()) return {};
  dem::Team alone(1);
  return dem::make(scene.model, scene.recipe, alone);
}

void settle_rows(RveScene& scene) {
  Output& out = scene.output;
  if (out.history_strain > 0)
    out.history_interval = out.history_strain / std::abs(scene.test.strain_rate);
  else if (out.history_interval == 0)
    out.history_interval = scene.test.duration / 200;
  if (!out.place_of_history.empty() && scene.test.duration / out.history_interval > 1e6)
    dem::refuse(out.place_of_history, "more than a million rows; ask for fewer");
  const double rows = scene.test.stages.empty() ? std::ceil(scene.test.duration / out.history_interval * (1 - 1e-9)) + 1
                                                : rows_of(scene.test);
  if (std::max(out.frames, out.gradings) > rows)
    scene.notes.push_back(
        fmt::format("output: {} {} are asked for, but one is written with a row of history.csv at most, of which there "
                    "are {:.0f}; shorten history_interval for more",
                    std::max(out.frames, out.gradings), out.frames > rows ? "frames" : "gradings", rows));
}

void settle(RveScene& scene, const dem::Sample& sample) {
  if (scene.model.numerics.inertia_step > 0)
    refuse_long_step(scene, sample.state.grains), refuse_real_time(scene, sample.state);
  if (scene.model.stepper->long_steps) refuse_real_time(scene, sample.state);
  refuse_large_fines(scene, sample.state.grains);
  if (const auto note = note_of_rigid(scene.model)) scene.notes.push_back(*note);
  scene.notes.insert(scene.notes.end(), sample.notes.begin(), sample.notes.end());
  scene.test = dem::fitted(std::move(scene.test), sample);
  if (scene.test.kind == dem::TestKind::platens) settle_rows(scene);
  if (scene.model.records_bonds && !sample.bonded()) dem::refuse(scene.output.place_of_bonds, no_bonds);
}

Base prepare_base(const RveScene& scene, const dem::Sample* made, dem::Team& team, const StageWatch& watch) {
  Base base;
  base.state = made ? made->state : dem::make(scene.model, scene.recipe, team, dem::stage_of(watch, "packing")).state;
  base.packed_void_ratio = dem::void_ratio(base.state);
  base.state =
      dem::compressed(std::move(base.state), scene.model, scene.recipe.preparation, team, watch, &base.density);
  return base;
}

nlohmann::json tell_preparation(const RveScene& scene, double packed_void_ratio, const dem::State& state,
                                const std::optional<dem::Vec3>& stresses, const dem::FoundDensity& density) {
  const auto& preparation = scene.recipe.preparation;
  if (!preparation) return {};
  const dem::Measurement m = dem::measure(scene.model, state);
  const dem::Vec3 asked = stresses.value_or(dem::Vec3::Constant(preparation->pressure)),
                  got = -dem::normal_stresses(state);
  // Voronoi cells of a rock leave no voids from the start: what is below 0 is their strain, or round-off.
  nlohmann::json told{{"asked_stress_Pa", {asked.x(), asked.y(), asked.z()}},
                      {"stress_Pa", {got.x(), got.y(), got.z()}},
                      {"worst_stress_error", (got.array() / asked.array() - 1).abs().maxCoeff()},
                      {"packed_void_ratio", std::max(0.0, packed_void_ratio)},
                      {"void_ratio", std::max(0.0, m.void_ratio)}};
  if (preparation->void_ratio && density.tries > 0)
    told["asked_void_ratio"] = *preparation->void_ratio, told["friction"] = density.friction,
    told["tries"] = density.tries;
  return told;
}

std::string note_of_preparations(const std::vector<nlohmann::json>& told) {
  const Preparations all(told);
  const auto mega = [](double p) { return fmt::format("{:.3g}", p / 1e6); };
  const auto exact = [](double e) { return fmt::format("{:.4f}", e); };
  if (all.tries > 0)
    return fmt::format(
        "preparation: a friction of {} leaves a void ratio of {} at {} MPa, {} was asked for ({}{} tried)",
        all.friction.text([](double f) { return fmt::format("{:.4g}", f); }), all.now.text(exact),
        all.pressure.text(mega), all.asked.text(exact), all.count > 1 ? "up to " : "", all.tries);
  if (!all.changed) return {};
  const auto ratio = [](double e) { return fmt::format("{:.3f}", e); };
  const auto solid = [](double e) { return fmt::format("{:.4f}", 1 / (1 + e)); };
  return fmt::format(
      "preparation: the packing has a void ratio of {} (solid fraction {}); compressed to {} MPa the sample begins the "
      "test at {} ({}). A lower preparation.friction makes it denser, a higher one looser",
      all.packed.text(ratio), all.packed.text(solid), all.pressure.text(mega), all.now.text(ratio),
      all.now.text(solid));
}

nlohmann::json sum_of_preparations(const std::vector<nlohmann::json>& told) {
  const Preparations all(told);
  if (all.count == 0) return {};
  nlohmann::json sum{{"starts", all.count},
                     {"asked_pressure_Pa", all.pressure.pair()},
                     {"packed_void_ratio", all.packed.pair()},
                     {"void_ratio", all.now.pair()},
                     {"worst_stress_error", all.worst}};
  if (all.tries > 0)
    sum["asked_void_ratio"] = all.asked.pair(), sum["friction"] = all.friction.pair(), sum["tries"] = all.tries;
  return sum;
}

dem::State prepare_sample(const RveScene& scene, dem::Team& team, const StageWatch& watch) {
  Base base = prepare_base(scene, nullptr, team, watch);
  return dem::start_from(std::move(base.state), scene.model, scene.recipe.preparation, team, watch);
}

}  // namespace grus::app
