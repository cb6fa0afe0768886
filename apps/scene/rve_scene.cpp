// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/rve_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>

#include "apps/scene/engine_scene.hpp"
#include "apps/scene/preparation_scene.hpp"
#include "apps/scene/prepare_sample.hpp"
#include "apps/scene/sample_scene.hpp"
#include "apps/scene/speeds.hpp"
#include "apps/scene/stage_scene.hpp"
#include "apps/scene/supports_scene.hpp"
#include "apps/scene/triaxial_scene.hpp"
#include "apps/scene/wall_scene.hpp"
#include "dem/packing/sphere_bonds.hpp"
#include "dem/rve/stepper.hpp"

namespace grus::app {
namespace {

using dem::Programme;
using Kind = dem::TestKind;

const std::vector<std::pair<std::string, Kind>> kinds{{"uniaxial-strain", Kind::uniaxial_strain},
                                                      {"oedometric-stress", Kind::oedometric_stress},
                                                      {"isotropic-stress", Kind::isotropic_stress},
                                                      {"triaxial", Kind::triaxial},
                                                      {"constant-p", Kind::constant_p},
                                                      {"true-triaxial", Kind::true_triaxial},
                                                      {"velocity-gradient", Kind::velocity_gradient},
                                                      {"platens", Kind::platens},
                                                      {"rollers", Kind::rollers},
                                                      {"free", Kind::free}};

Kind read_kind(Table& t) {
  std::vector<std::string> names;
  for (const auto& [name, kind] : kinds) names.push_back(name);
  const std::string asked = t.choice("kind", names);
  return std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.first == asked; })->second;
}

void needs_box(const Table& t, const RveScene& scene) {
  const Kind kind = scene.test.kind;
  const auto named = std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.second == kind; });
  if (scene.recipe.in_cylinder() && kind != Kind::uniaxial_strain && kind != Kind::oedometric_stress)
    t.fail("kind", fmt::format("\"{}\" cannot be in a cylinder, whose wall stays; use \"uniaxial-strain\" or "
                               "\"oedometric-stress\"",
                               named->first));
  if (scene.recipe.bounds == dem::Bounds::periodic_xy && kind != Kind::uniaxial_strain &&
      kind != Kind::oedometric_stress)
    t.fail("kind", fmt::format("\"{}\" cannot be with boundary.kind = \"periodic-xy\", whose sides stay; use \"free\" "
                               "with [[wall]], \"uniaxial-strain\" or \"oedometric-stress\"",
                               named->first));
  if (scene.recipe.bounds == dem::Bounds::open)
    t.fail("kind", fmt::format("\"{}\" needs boundary.kind = \"walls\" or \"periodic\"", named->first));
}

void read_axis(Table& t, Programme& test) { test.axis = t.choice_or("axis", "z", {"x", "y", "z"})[0] - 'x'; }

dem::AxisControl& loaded_axis(Programme& test) { return test.loading.axes[static_cast<std::size_t>(test.axis)]; }

void read_uniaxial_strain(Table& t, Programme& test) {
  read_axis(t, test);
  test.strain_rate = t.number("strain_rate", dimension::rate, any);
  if (test.strain_rate == 0) t.fail("strain_rate", "must not be 0");
  const double strain = t.number("final_strain", dimension::none, {0, 0.95, true, true});
  test.duration = strain / std::abs(test.strain_rate);
  loaded_axis(test).strain_rate = -test.strain_rate;
}

void read_oedometric_stress(Table& t, Programme& test) {
  read_axis(t, test);
  test.strain_rate = t.number("strain_rate", dimension::rate, positive);
  test.final_stress = t.number("final_stress", dimension::pressure, positive);
  test.duration = t.number_or("max_strain", 0.6, dimension::none, {0, 0.95, true, true}) / test.strain_rate;
  if (t.choice_or("control", "strain", {"strain", "stress"}) == "strain") {
    if (t.has("stress_rate")) t.fail("stress_rate", "is for control = \"stress\"");
    loaded_axis(test).strain_rate = -test.strain_rate;
    return;
  }
  const double rate = t.number("stress_rate", dimension::stress_rate, positive);
  test.stress_time = *test.final_stress / rate;
  test.duration = std::max(test.duration, 1.1 * *test.stress_time);
  loaded_axis(test) = {.stress = 0, .max_rate = test.strain_rate, .stress_rate = -rate};
}

void read_isotropic_stress(Table& t, Programme& test) {
  test.strain_rate = t.number("strain_rate", dimension::rate, positive);
  const double pressure = t.number("pressure", dimension::pressure, positive);
  test.duration = t.number("duration", dimension::time, positive);
  for (auto& axis : test.loading.axes) axis = {0, -pressure, test.strain_rate};
}

void read_triaxial(Table& t, Programme& test) {
  read_axis(t, test);
  test.strain_rate = t.number("strain_rate", dimension::rate, positive);
  const double pressure = t.number("confining_pressure", dimension::pressure, positive);
  test.duration = t.number("final_strain", dimension::none, {0, 0.95, true, true}) / test.strain_rate;
  for (auto& axis : test.loading.axes) axis = {0, -pressure, 2 * test.strain_rate};
  loaded_axis(test) = {.strain_rate = -test.strain_rate, .stress = {}};
  test.loading.holds = true;
}

/// True triaxial: one axis is compressed (or, at a negative rate, drawn), the two others keep the mean stress.
void read_constant_p(Table& t, Programme& test) {
  read_axis(t, test);
  test.strain_rate = t.number("strain_rate", dimension::rate, any);
  if (test.strain_rate == 0) t.fail("strain_rate", "must not be 0");
  const double rate = std::abs(test.strain_rate);
  test.loading.mean = -t.number("pressure", dimension::pressure, positive);
  const double shearing = t.number("final_strain", dimension::none, {0, 0.95, true, true}) / rate;
  test.loading.consolidation = t.number_or("consolidation", 0.2 * shearing, dimension::time, positive);
  test.duration = test.loading.consolidation + shearing;
  for (auto& axis : test.loading.axes) axis = {0, *test.loading.mean, 6 * rate};
  loaded_axis(test) = {.strain_rate = -test.strain_rate, .stress = {}, .max_rate = 6 * rate};
  test.loading.holds = true;
}

void read_velocity_gradient(Table& t, RveScene& scene) {
  if (!scene.recipe.periodic()) t.fail("kind", "\"velocity-gradient\" needs boundary.kind = \"periodic\"");
  const auto m = t.matrix("velocity_gradient", dimension::rate);
  dem::Mat3 gradient;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) gradient(i, j) = m[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  scene.test.duration = t.number("duration", dimension::time, positive);
  scene.test.strain_rate = gradient.norm();
  scene.test.loading.velocity_gradient = gradient;
}

/// Rates at which a side, or what a cell repeats, would outrun every wave; pressures that no grain can bear.
void refuse_outrun(const Table& t, const RveScene& scene) {
  const Programme& test = scene.test;
  const dem::Vec3& box = scene.recipe.box;
  if (const auto& gradient = test.loading.velocity_gradient) {
    for (int k = 0; k < 3; ++k) refuse_fast_rate(t, "velocity_gradient", gradient->col(k).norm(), box[k], scene.model);
    return;
  }
  for (int k = 0; k < 3; ++k) {
    const dem::AxisControl& axis = test.loading.axes[static_cast<std::size_t>(k)];
    if (test.kind == Kind::true_triaxial) {
      const std::string name(1, "xyz"[k]);
      refuse_fast_rate(t, name, axis.strain_rate, box[k], scene.model);
      refuse_high_pressure(t, name, -(*test.loading.first)[k], scene.model);
    } else if (axis.stress) {
      const char* const key = t.has("confining_pressure") ? "confining_pressure" : "pressure";
      refuse_high_pressure(t, key, -*axis.stress, scene.model);
    }
  }
  if (test.strain_rate != 0 && t.has("strain_rate"))
    refuse_fast_rate(t, "strain_rate", test.strain_rate,
                     test.kind == Kind::isotropic_stress ? box.maxCoeff() : box[test.axis], scene.model);
}

/// Stresses of walls that press must not go on, until the test ends, to what no grain can bear.
void refuse_late_stress(const Table& t, const RveScene& scene) {
  for (const dem::WallControl& c : scene.test.loading.walls)
    refuse_high_pressure(t, "duration", std::abs(c.stress_rate) * scene.test.duration, scene.model,
                         fmt::format("wall {}: stress_rate brings it to ", c.wall));
}

void read_loading(Table t, RveScene& scene) {
  Programme& test = scene.test;
  test.kind = read_kind(t);
  if (test.kind != Kind::free) refuse_own_motion(t, "kind", scene);
  t.number_or("scale", 1, dimension::none, {1e-6, 1e6});  // read before the sample
  const std::map<Kind, void (*)(Table&, Programme&)> of_a_box{{Kind::uniaxial_strain, read_uniaxial_strain},
                                                              {Kind::oedometric_stress, read_oedometric_stress},
                                                              {Kind::isotropic_stress, read_isotropic_stress},
                                                              {Kind::triaxial, read_triaxial},
                                                              {Kind::constant_p, read_constant_p},
                                                              {Kind::true_triaxial, read_true_triaxial}};
  const std::map<Kind, void (*)(Table&, RveScene&)> of_its_own{
      {Kind::velocity_gradient, read_velocity_gradient}, {Kind::platens, read_platens}, {Kind::rollers, read_rollers}};
  if (const auto read = of_a_box.find(test.kind); read != of_a_box.end()) {
    needs_box(t, scene);
    test.loading.driven = true;
    read->second(t, test);
    if (scene.recipe.in_cylinder() && test.axis != 2) t.fail("axis", "of a cylinder is \"z\"");
    if (scene.recipe.bounds == dem::Bounds::periodic_xy && test.axis != 2)
      t.fail("axis", "of \"periodic-xy\" is \"z\"");
  } else if (test.kind == Kind::free) {
    test.duration = t.number("duration", dimension::time, positive);
    refuse_late_stress(t, scene);
  } else {
    of_its_own.at(test.kind)(t, scene);
  }
  refuse_outrun(t, scene);
  const auto g = t.numbers_or("gravity", {0, 0, 0}, dimension::acceleration);
  scene.model.motion.gravity = {g[0], g[1], g[2]};
  if (scene.model.stepper->long_steps) check_implicit(t, scene.model, test.kind);
  if (scene.model.numerics.inertia_step > 0 && test.kind == Kind::free)
    t.fail("kind", "\"free\" is of real time: numerics.inertia.step would change what the grains do in it");
  if (scene.model.numerics.scales_inertia() && !scene.model.motion.gravity.isZero())
    t.fail("gravity", "cannot be with numerics.inertia: what resists motion would weigh, too");
  t.finish();
}

/// In strain where the test has a rate; a text with a unit of time, or a test without a rate, in seconds.
void read_interval(Table& t, const Programme& test, Output& out) {
  bool in_time = test.strain_rate == 0 && test.kind != Kind::platens;
  double value = 0;
  try {
    value = t.number("history_interval", dimension::none, positive);
  } catch (const InputError&) {
    value = t.number("history_interval", dimension::time, positive);
    in_time = true;
  }
  (in_time ? out.history_interval : out.history_strain) = value;
  out.place_of_history = t.place("history_interval");
}

void read_output_table(Table& t, RveScene& scene) {
  Output& out = scene.output;
  if (t.has("history_interval") && !scene.test.stages.empty())
    t.fail("history_interval", "is not of a test with stages: give rows of a stage");
  if (t.has("history_interval")) read_interval(t, scene.test, out);
  scene.model.split_statistics = t.flag_or("split_statistics", false);
  if (scene.model.split_statistics && !scene.model.breakable())
    t.fail("split_statistics", "is of grains that break, of which there are none: give a material fracture");
  out.grading = t.flag_or("grading", false);
  const auto record_bonds = [&](const char* key) {
    const auto& all = scene.model.materials;
    if (std::none_of(all.begin(), all.end(), [](const auto& m) { return m.bond.has_value(); })) t.fail(key, no_bonds);
    out.place_of_bonds = t.place(key), scene.model.records_bonds = true;
  };
  if (t.has("bursts")) out.bursts = t.number("bursts", dimension::time, positive), record_bonds("bursts");
  out.broken_bonds = t.flag_or("broken_bonds", false);
  if (out.broken_bonds) record_bonds("broken_bonds");
  out.gradings = static_cast<int>(t.integer_or("gradings", 0, 0, 1000));
  out.lattice = static_cast<std::size_t>(t.integer_or("lattice", 0, 0, 1000));
  if (out.lattice > 0 && !scene.model.tests_cracks())
    t.fail("lattice", "is of grains that break by model = \"peridynamics\", of which there are none");
  for (dem::Material& m : scene.model.materials)
    if (m.fracture && m.fracture->cracks) m.fracture->cracks->lattice.tells_points = out.lattice > 0;
  out.critical_grain = t.flag_or("critical_grain", false);
  out.wall_forces = t.flag_or("wall_forces", false);
  if (out.wall_forces && !scene.recipe.has_sides())
    t.fail("wall_forces", "is of a box or cylinder of walls; forces of other walls are told in any case");
  out.strain_gauges = t.flag_or("strain_gauges", false);
  if (out.strain_gauges && scene.test.kind != Kind::platens)
    t.fail("strain_gauges", "are on the middle of a sample between platens: loading.kind = \"platens\"");
  out.frames = static_cast<int>(t.integer_or("frames", 0, 0, 100000));
  out.contacts = t.flag_or("contacts", false);
  out.wrapped = t.flag_or("wrapped", false);
  for (const char* key : {"contacts", "wrapped"})
    if (t.flag_or(key, false) && out.frames == 0) t.fail(key, "is of frames, of which none are asked for: give frames");
  if (out.wrapped && !scene.recipe.repeats()) t.fail("wrapped", "needs boundary.kind = \"periodic\"");
  out.last_state = t.flag_or("last_state", !scene.test.stages.empty());
  out.checkpoint_interval = t.number_or("checkpoint_interval", out.checkpoint_interval, dimension::time, positive);
  t.finish();
}

void read_output(Table& t, RveScene& scene) {
  scene.output.last_state = !scene.test.stages.empty();
  if (auto o = t.table_if("output")) read_output_table(*o, scene);
  if (scene.test.kind != Kind::platens) settle_rows(scene);
}

/// Larger grains that stand for smaller ones are as strong as those, and press alike.
void scale_strengths(RveScene& scene) {
  for (auto& m : scene.model.materials) {
    dem::scale(scene.model.law, m.contact, scene.scale);
    if (!m.fracture) continue;
    if (auto* scatter = std::get_if<dem::Scatter>(&m.fracture->strength_law))
      scatter->reference_diameter *= scene.scale;
    if (auto* weibull = std::get_if<dem::Weibull>(&m.fracture->strength_law)) weibull->reference_radius *= scene.scale;
  }
}

/// A sample that is prepared to more than a test asks for has done it.
void note_end(RveScene& scene) {
  const auto& preparation = scene.recipe.preparation;
  if (preparation && scene.test.final_stress && *scene.test.final_stress <= preparation->pressure)
    scene.notes.push_back(
        fmt::format("loading.final_stress = {:.4g} Pa is no more than preparation.pressure = {:.4g} Pa: the test ends "
                    "as it begins",
                    *scene.test.final_stress, preparation->pressure));
}

RveScene read(const std::string& file, const std::vector<std::string>& overrides, bool unit_cell) {
  RveScene scene;
  scene.file = file;
  const toml::table parsed = parse_scene(file, overrides, unit_cell ? "set" : "--set");
  const auto record = std::make_shared<nlohmann::json>();
  scene.record = record;
  Table t(parsed, file, "", *record);
  scene.title = t.text_or("title", std::filesystem::path(file).stem().string());
  // Listed grains are verification cases: some hundred steps an impact. Packings need stability, not each collision's
  // shape.
  if (t.has("grain")) scene.model.numerics.safety = 0.02;
  scene.model.seed = static_cast<std::uint64_t>(t.integer_or("seed", 1, 0, 1L << 62));
  read_model(t, scene.model, unit_cell);
  if (auto loading = t.table_if("loading")) scene.scale = loading->number_or("scale", 1, dimension::none, {1e-6, 1e6});
  scale_strengths(scene);
  read_sample(t, *record, scene);
  read_supports(t, scene);
  if (unit_cell) {
    if (!scene.recipe.periodic()) t.fail("boundary", "the unit cell of a boundary-value problem must be periodic");
    RveScene alone = scene;  // the standalone test: read, so that its mistakes show, but not used here
    if (t.has("stage")) read_stages(t, alone);
    if (t.has("loading")) read_loading(t.table("loading"), alone);
    if (t.has("loading") || t.has("stage") || t.has("output")) read_output(t, alone);
  } else {
    if (!t.has("loading") && !t.has("stage")) t.fail("", "[loading] is missing");
    if (t.has("stage"))
      read_stages(t, scene);
    else
      read_loading(t.table("loading"), scene);
    read_output(t, scene);
  }
  dem::make_pair_laws(scene.model);
  if (!unit_cell && t.has("start")) {
    scene.start = t.text("start"), scene.place_of_start = t.place("start");
    if (scene.start.empty()) t.fail("start", "names no folder; give that of a run, or leave start out");
    if (t.has("preparation")) t.fail("preparation", "cannot be with start: that run has prepared the sample");
  }
  read_preparation(t, scene);
  if (scene.recipe.preparation) scene.test.loading.prepared = -scene.recipe.preparation->pressure;
  note_end(scene);
  t.finish();
  scene.model.motion.turn_spheres =
      scene.listed_grains() > 0 || scene.model.breakable() || dem::bonds_spheres(scene.model);
  return scene;
}

}  // namespace

RveScene read_rve_scene(const std::string& file, const std::vector<std::string>& overrides) {
  return read(file, overrides, false);
}

RveScene read_unit_cell(const std::string& file, const std::vector<std::string>& overrides) {
  return read(file, overrides, true);
}

}  // namespace grus::app
