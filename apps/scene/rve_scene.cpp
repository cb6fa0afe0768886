// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/rve_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>

#include "apps/scene/preparation_scene.hpp"
#include "apps/scene/sample_scene.hpp"
#include "apps/scene/supports_scene.hpp"
#include "dem/rve/measure.hpp"

namespace grus::app {
namespace {

const std::vector<std::string> kinds{"uniaxial-strain", "oedometric-stress", "isotropic-stress",
                                     "triaxial",        "constant-p",        "velocity-gradient",
                                     "platens",         "rollers",           "free"};

void needs_box(const Table& t, const RveScene& scene) {
  const dem::Boundary& boundary = scene.state.boundary;
  if (dem::cylinder(boundary) && scene.test.kind != "uniaxial-strain" && scene.test.kind != "oedometric-stress")
    t.fail("kind", fmt::format("\"{}\" cannot be in a cylinder, whose wall stays; use \"uniaxial-strain\" or "
                               "\"oedometric-stress\"",
                               scene.test.kind));
  if (boundary.cell.periodic() || (!boundary.walls.empty() && !boundary.walls[0].name.empty())) return;
  t.fail("kind", fmt::format("\"{}\" needs boundary.kind = \"walls\" or \"periodic\"", scene.test.kind));
}

void read_axis(Table& t, TestProgram& test) { test.axis = t.choice_or("axis", "z", {"x", "y", "z"})[0] - 'x'; }

dem::AxisControl& loaded_axis(TestProgram& test) { return test.loading.axes[static_cast<std::size_t>(test.axis)]; }

void read_uniaxial_strain(Table& t, TestProgram& test) {
  read_axis(t, test);
  test.strain_rate = t.number("strain_rate", dimension::rate, any);
  if (test.strain_rate == 0) t.fail("strain_rate", "must not be 0");
  const double strain = t.number("final_strain", dimension::none, {0, 0.95, true, true});
  test.duration = strain / std::abs(test.strain_rate);
  loaded_axis(test).strain_rate = -test.strain_rate;
}

void read_oedometric_stress(Table& t, TestProgram& test) {
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

void read_isotropic_stress(Table& t, TestProgram& test) {
  test.strain_rate = t.number("strain_rate", dimension::rate, positive);
  const double pressure = t.number("pressure", dimension::pressure, positive);
  test.duration = t.number("duration", dimension::time, positive);
  for (auto& axis : test.loading.axes) axis = {0, -pressure, test.strain_rate};
}

void read_triaxial(Table& t, TestProgram& test) {
  read_axis(t, test);
  test.strain_rate = t.number("strain_rate", dimension::rate, positive);
  const double pressure = t.number("confining_pressure", dimension::pressure, positive);
  test.duration = t.number("final_strain", dimension::none, {0, 0.95, true, true}) / test.strain_rate;
  for (auto& axis : test.loading.axes) axis = {0, -pressure, 2 * test.strain_rate};
  loaded_axis(test) = {.strain_rate = -test.strain_rate, .stress = {}};
  test.loading.holds = true;
}

/// True triaxial: one axis is compressed (or, at a negative rate, drawn), the two others keep the mean stress.
void read_constant_p(Table& t, TestProgram& test) {
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
  if (!scene.state.boundary.cell.periodic()) t.fail("kind", "\"velocity-gradient\" needs boundary.kind = \"periodic\"");
  const auto m = t.matrix("velocity_gradient", dimension::rate);
  dem::Mat3 gradient;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) gradient(i, j) = m[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  scene.test.duration = t.number("duration", dimension::time, positive);
  scene.test.strain_rate = gradient.norm();
  scene.test.loading.velocity_gradient = gradient;
}

/// Section that platens press on; of a disc across its axis pi D t / 2, which makes it the tension in its middle.
double nominal_area(const RveScene::Cells& cells, int axis) {
  const dem::Vec3& box = cells.box;
  if (!cells.round) return box.prod() / box[axis];
  return axis == 2 ? 0.25 * dem::pi * box.x() * box.x() : 0.5 * dem::pi * box.x() * box.z();
}

/// The mean of both.
void measure_platens(RveScene& scene, int axis) {
  RveScene::Gauge gauge{{{0, 0.5}, {1, -0.5}}, -dem::Vec3::Unit(axis), 1, 1 / nominal_area(*scene.cells, axis)};
  scene.cells->gauge = gauge;
}

void read_platens(Table& t, RveScene& scene) {
  TestProgram& test = scene.test;
  auto& walls = scene.state.boundary.walls;
  if (scene.state.boundary.cell.periodic() || !walls.empty())
    t.fail("kind", "\"platens\" makes its own two walls; leave out [boundary] and [[wall]]");
  read_axis(t, test);
  const double friction = t.number_or("friction", NAN, dimension::none, not_negative);
  dem::Team alone(1);
  make_sample(scene, alone, {});  // the platens touch it
  add_platens(t, scene, test.axis, 0, friction);
  const double height = walls[1].point[test.axis] - walls[0].point[test.axis];
  const bool by_speed = t.has("speed");
  if (by_speed == t.has("strain_rate")) t.fail("", "needs either speed or strain_rate");
  const double speed = by_speed ? t.number("speed", dimension::speed, positive)
                                : height * t.number("strain_rate", dimension::rate, positive);
  walls[1].velocity[test.axis] = -speed;
  if (scene.cells) measure_platens(scene, test.axis);
  test.strain_rate = speed / height;
  test.duration = t.number("final_strain", dimension::none, {0, 0.95, true, true}) / test.strain_rate;
}

void read_loading(Table t, RveScene& scene) {
  TestProgram& test = scene.test;
  test.kind = t.choice("kind", kinds);
  t.number_or("scale", 1, dimension::none, {1e-6, 1e6});  // read before the sample
  const std::map<std::string, void (*)(Table&, TestProgram&)> of_a_box{{"uniaxial-strain", read_uniaxial_strain},
                                                                       {"oedometric-stress", read_oedometric_stress},
                                                                       {"isotropic-stress", read_isotropic_stress},
                                                                       {"triaxial", read_triaxial},
                                                                       {"constant-p", read_constant_p}};
  if (const auto read = of_a_box.find(test.kind); read != of_a_box.end()) {
    needs_box(t, scene);
    test.loading.driven = true;
    read->second(t, test);
    if (dem::cylinder(scene.state.boundary) && test.axis != 2) t.fail("axis", "of a cylinder is \"z\"");
  } else if (test.kind == "velocity-gradient") {
    read_velocity_gradient(t, scene);
  } else if (test.kind == "platens") {
    read_platens(t, scene);
  } else if (test.kind == "rollers") {
    read_rollers(t, scene);
  } else {
    test.duration = t.number("duration", dimension::time, positive);
  }
  const auto g = t.numbers_or("gravity", {0, 0, 0}, dimension::acceleration);
  scene.model.motion.gravity = {g[0], g[1], g[2]};
  if (scene.model.numerics.scaled_below > 0 && !scene.model.motion.gravity.isZero())
    t.fail("gravity", "cannot be with numerics.inertia: what resists motion would weigh, too");
  t.finish();
}

void read_output(Table& t, RveScene& scene) {
  Output& out = scene.output;
  out.history_interval = scene.test.duration / 200;
  auto o = t.table_if("output");
  if (!o) return;
  if (o->has("history_interval")) {
    // In strain where the test has a rate; a text with a unit of time, or a test without a rate, in seconds.
    const double rate = std::abs(scene.test.strain_rate);
    bool in_time = rate == 0;
    double value = 0;
    try {
      value = o->number("history_interval", dimension::none, positive);
    } catch (const InputError&) {
      value = o->number("history_interval", dimension::time, positive);
      in_time = true;
    }
    out.history_interval = in_time ? value : value / rate;
    if (scene.test.duration / out.history_interval > 1e6)
      o->fail("history_interval", "more than a million rows; ask for fewer");
  }
  scene.model.split_statistics = o->flag_or("split_statistics", false);
  if (scene.model.split_statistics && !scene.model.breakable())
    o->fail("split_statistics", "is of grains that break, of which there are none: give a material fracture");
  out.grading = o->flag_or("grading", false);
  if (o->has("bursts")) {
    if (!scene.bonded()) o->fail("bursts", "the scene has no cells with bonds");
    out.bursts = o->number("bursts", dimension::time, positive);
    scene.model.records_bonds = true;
  }
  out.gradings = static_cast<int>(o->integer_or("gradings", 0, 0, 1000));
  out.frames = static_cast<int>(o->integer_or("frames", 0, 0, 100000));
  out.contacts = o->flag_or("contacts", false);
  out.wrapped = o->flag_or("wrapped", false);
  for (const char* key : {"contacts", "wrapped"})
    if (o->flag_or(key, false) && out.frames == 0)
      o->fail(key, "is of frames, of which none are asked for: give frames");
  if (out.wrapped && !scene.state.boundary.cell.periodic()) o->fail("wrapped", "needs boundary.kind = \"periodic\"");
  const double rows = std::ceil(scene.test.duration / out.history_interval * (1 - 1e-9)) + 1;
  if (std::max(out.frames, out.gradings) > rows)
    scene.notes.push_back(
        fmt::format("output: {} {} are asked for, but one is written with a row of history.csv at most, of which there "
                    "are {:.0f}; shorten history_interval for more",
                    std::max(out.frames, out.gradings), out.frames > rows ? "frames" : "gradings", rows));
  out.checkpoint_interval = o->number_or("checkpoint_interval", out.checkpoint_interval, dimension::time, positive);
  o->finish();
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

RveScene read(const std::string& file, const std::vector<std::string>& overrides, bool unit_cell) {
  RveScene scene;
  scene.file = file;
  const toml::table parsed = parse_scene(file, overrides);
  Table t(parsed, file, "", scene.record);
  scene.title = t.text_or("title", std::filesystem::path(file).stem().string());
  // Listed grains are verification cases: some hundred steps an impact. Packings need stability, not each collision's
  // shape.
  if (t.has("grain")) scene.model.numerics.safety = 0.02;
  scene.model.seed = static_cast<std::uint64_t>(t.integer_or("seed", 1, 0, 1L << 62));
  read_model(t, scene.model, unit_cell);
  if (auto loading = t.table_if("loading")) scene.scale = loading->number_or("scale", 1, dimension::none, {1e-6, 1e6});
  scale_strengths(scene);
  read_sample(t, scene);
  read_supports(t, scene);
  if (unit_cell) {
    if (!scene.state.boundary.cell.periodic())
      t.fail("boundary", "the unit cell of a boundary-value problem must be periodic");
    RveScene alone = scene;  // the standalone test: read, so that its mistakes show, but not used here
    if (t.has("loading")) read_loading(t.table("loading"), alone);
    if (t.has("loading") || t.has("output")) read_output(t, alone);
  } else {
    if (!t.has("loading")) t.fail("", "[loading] is missing");
    read_loading(t.table("loading"), scene);
    read_output(t, scene);
  }
  dem::make_pair_laws(scene.model);
  read_preparation(t, scene);
  t.finish();
  scene.model.motion.turn_spheres = scene.listed_grains > 0 || scene.model.breakable();
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
