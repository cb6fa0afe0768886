// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/scene/bvp_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "apps/bvp/scene/mesh_scene.hpp"
#include "apps/scene/unit_cells.hpp"

namespace grus::app {
namespace {

void read_rve(Table t, BvpScene& scene) {
  const std::string file = t.path("scene");
  if (!std::filesystem::is_regular_file(file))
    t.fail("scene", fmt::format("\"{}\": no such scene file", t.text("scene")));
  if (t.has("adaptivity") && scene.is_explicit())
    t.fail("adaptivity",
           "sharing and deferral are for \"quasi-static\": in explicit runs an RVE does not go back to where another "
           "has been; leave the key out");
  scene.rve = read_rve_options(t);
  if (scene.rve.share > 0 && scene.spread)
    t.fail("adaptivity.share", "points that ride on one RVE may lie on different ranks where solve.spread = true");
  dem::ResponseOptions& response = scene.rve.response;
  using dem::Pace;
  if (scene.dynamics) scene.rve.pace = Pace::real_time;
  if (scene.explicit_statics) scene.rve.pace = Pace::steady;
  if (t.has("damping")) scene.damping = t.number("damping", dimension::none, {0, 1, false, true});
  if (t.choice_or("on_failure", "stop", {"stop", "elastic"}) == "elastic") {
    if (!scene.explicit_statics) t.fail("on_failure", "\"elastic\" needs solve.kind = \"explicit-quasi-static\"");
    response.on_failure = dem::OnFailure::elastic;
  }
  scene.variants = static_cast<int>(t.integer_or("variants", 1, 1, 100000));
  const std::vector<std::string> changes = t.texts_or_none("set");
  t.finish();
  scene.unit_cells = read_unit_cells(file, changes, scene.variants);
  for (RveScene& cell : scene.unit_cells)
    if (const auto& sample = scene.samples.emplace_back(made_at_once(cell))) settle(cell, *sample);
  if (scene.dynamics && scene.unit_cells[0].model.numerics.scales_inertia())
    t.fail("scene", "numerics.inertia of the RVE is for quasi-static runs: waves would see it");
  default_floor(response, scene.unit_cells[0]);
  scene.has_rve = true;
}

fem::DynamicsOptions read_dynamics(Table& t) {
  fem::DynamicsOptions d;
  d.duration = t.number("duration", dimension::time, positive);
  d.safety = t.number_or("safety", d.safety, dimension::none, {0, 1.5, true});
  if (t.has("time_step")) d.time_step = t.number("time_step", dimension::time, positive);
  d.linear_viscosity = t.number_or("linear_viscosity", 0, dimension::none, {0, 10});
  d.quadratic_viscosity = t.number_or("quadratic_viscosity", 0, dimension::none, {0, 100});
  d.estimate_every = static_cast<int>(t.integer_or("estimate_every", d.estimate_every, 1, 1000000));
  d.max_energy_error = t.number_or("max_energy_error", d.max_energy_error, dimension::none, positive);
  return d;
}

/// Limits below which no rate of loading gets: RVEs of grains are never that quiet.
fem::ExplicitStaticsOptions read_explicit_statics(Table& t) {
  fem::ExplicitStaticsOptions e;
  e.balance = t.number_or("balance", e.balance, dimension::none, {1e-4, 0.5});
  e.kinetic = t.number_or("kinetic", e.kinetic, dimension::none, {1e-6, 0.5});
  e.inertial_number = t.number_or("inertial_number", e.inertial_number, dimension::none, {1e-7, 0.1});
  e.damping = t.number_or("damping", e.damping, dimension::none, {0, 1, false, true});
  e.safety = t.number_or("safety", e.safety, dimension::none, {0.05, 0.95});
  e.crossings = t.number_or("crossings", e.crossings, dimension::none, {1, 1e6});
  e.max_energy_error = t.number_or("max_energy_error", e.max_energy_error, dimension::none, positive);
  return e;
}

void read_solve(Table t, BvpScene& scene) {
  const std::string kind = t.choice("kind", {"quasi-static", "explicit-dynamic", "explicit-quasi-static"});
  if (kind == "explicit-dynamic") scene.dynamics = read_dynamics(t);
  if (kind == "explicit-quasi-static") scene.explicit_statics = read_explicit_statics(t);
  if (t.has("spread")) scene.spread = t.flag_or("spread", false);
  if (t.has("patience") && !scene.spread) t.fail("patience", "ranks wait for each other where solve.spread = true");
  if (scene.spread) scene.patience = t.number_or("patience", scene.patience, dimension::time, {1, 1e9});
  scene.discretisation.exact_sums = scene.spread;
  if (scene.is_explicit()) return t.finish();
  fem::StaticsOptions& s = scene.solve;
  s.increments = static_cast<int>(t.integer_or("increments", 10, 1, 1000000));
  s.tolerance = t.number_or("tolerance", s.tolerance, dimension::none, {0, 0.1, true});
  s.displacement_tolerance =
      t.number_or("displacement_tolerance", s.displacement_tolerance, dimension::none, {0, 1, true});
  s.max_cutbacks = static_cast<int>(t.integer_or("max_cutbacks", s.max_cutbacks, 0, 100));
  s.acceleration = static_cast<int>(t.integer_or("acceleration", s.acceleration, 0, 50));
  s.max_iterations = static_cast<int>(t.integer_or("max_iterations", s.max_iterations, 1, 1000));
  if (t.has("linear_solver") && t.choice_or("linear_solver", "direct", {"direct", "iterative"}) == "iterative")
    s.linear = fem::LinearMethod::iterative;
  if (scene.spread)
    scene.notes.push_back(
        "solve.spread with \"quasi-static\": linear systems are solved on all ranks, so that another number of ranks "
        "gives the same results to Newton's tolerance, not to the bit");
  t.finish();
}

void read_probe(Table p, BvpScene& scene) {
  Probe probe;
  probe.name = p.text("name");
  if (probe.name.empty() || probe.name.find_first_of(", /\"\n") != std::string::npos)
    p.fail("name", "must be a word: it becomes part of column and file names");
  for (const auto& other : scene.probes)
    if (other.name == probe.name) p.fail("name", fmt::format("\"{}\": two probes have this name", probe.name));
  if (p.has("at") == p.has("where")) p.fail("", "needs either at or where");
  if (p.has("where")) {
    probe.where = read_where(p, scene);
    for (const char* key : {"frames", "grading"})
      if (p.has(key)) p.fail(key, "is of one point's grains; a probe with where tells means");
    p.finish();
    scene.probes.push_back(probe);
    return;
  }
  const auto x = p.numbers("at", scene.flat() && p.length("at") == 2 ? 2 : 3, dimension::length);
  for (std::size_t k = 0; k < (scene.flat() ? 2 : 3); ++k) {
    probe.at[k] = x[k];
    if (x[k] < scene.low[k] || x[k] > scene.high[k]) p.fail("at", "lies outside the mesh");
  }
  probe.frames = p.flag_or("frames", false);
  probe.grading = p.flag_or("grading", false);
  p.finish();
  scene.probes.push_back(probe);
}

void read_output(Table o, BvpScene& scene) {
  scene.frames = static_cast<int>(o.integer_or("frames", 0, 0, 100000));
  scene.costs = o.flag_or("costs", false);
  scene.checkpoint_interval = o.number_or("checkpoint_interval", scene.checkpoint_interval, dimension::time, positive);
  if (scene.dynamics) {
    scene.dynamics->output_interval =
        o.number_or("history_interval", scene.dynamics->duration / 200, dimension::time, positive);
    if (scene.dynamics->duration / scene.dynamics->output_interval > 1e6)
      o.fail("history_interval", "more than a million rows; ask for fewer");
  }
  if (scene.explicit_statics) {
    double& interval = scene.explicit_statics->output_interval;
    interval = o.number_or("history_interval", interval, dimension::none, {1e-6, 1});
  }
  double rows = scene.solve.increments;
  if (scene.explicit_statics) rows = std::ceil(1 / scene.explicit_statics->output_interval * (1 - 1e-9));
  if (scene.dynamics) rows = std::ceil(scene.dynamics->duration / scene.dynamics->output_interval * (1 - 1e-9));
  if (scene.frames > rows)
    scene.notes.push_back(fmt::format(
        "output.frames = {}, but one is written with a row of history.csv at most, of which there are {:.0f}{}",
        scene.frames, rows, scene.is_explicit() ? "" : " where no increment is cut"));
  o.finish();
}

void read_hopkinson(Table h, BvpScene& scene) {
  if (!scene.dynamics) h.fail("", "needs solve.kind = \"explicit-dynamic\"");
  Hopkinson bar;
  for (auto* gauge : {&bar.incident, &bar.transmitted}) {
    const std::string key = gauge == &bar.incident ? "incident_gauge" : "transmitted_gauge";
    *gauge = h.text(key);
    if (std::none_of(scene.probes.begin(), scene.probes.end(), [&](const Probe& p) { return p.name == *gauge; }))
      h.fail(key, fmt::format("no probe has the name \"{}\"", *gauge));
  }
  bar.bar_modulus = h.number("bar_modulus", dimension::pressure, positive);
  bar.bar_density = h.number("bar_density", dimension::density, positive);
  bar.bar_area = h.number("bar_area", dimension::area, positive);
  bar.specimen_length = h.number("specimen_length", dimension::length, positive);
  bar.specimen_area = h.number("specimen_area", dimension::area, positive);
  bar.incident_distance = h.number("incident_distance", dimension::length, positive);
  bar.transmitted_distance = h.number("transmitted_distance", dimension::length, positive);
  const std::string axis = h.choice_or("axis", "y", {"x", "y", "z"});
  bar.axis = axis[0] - 'x';
  h.finish();
  scene.hopkinson = bar;
}

void read_gravity(Table& t, BvpScene& scene) {
  const auto g = t.numbers("gravity", scene.flat() && t.length("gravity") == 2 ? 2 : 3, dimension::acceleration);
  std::copy(g.begin(), g.end(), scene.gravity.begin());
  if (scene.flat() && scene.gravity[2] != 0) t.fail("gravity", "two dimensions have no weight along z");
  if (scene.discretisation.kinematics == fem::Kinematics::axisymmetric && scene.gravity[0] != 0)
    t.fail("gravity", "acts along the axis (y) where x is the radius");
}

void read_ground(Table t, BvpScene& scene) {
  Ground g;
  g.k0 = t.number("k0", dimension::none, {0, 10, true});
  g.axis = t.choice_or("axis", scene.flat() ? "y" : "z", {"x", "y", "z"})[0] - 'x';
  const auto axis = static_cast<std::size_t>(g.axis);
  if (scene.flat() && g.axis == 2) t.fail("axis", "two dimensions have no depth along z");
  g.surface = t.number_or("surface", scene.high[axis], dimension::length, any);
  g.surcharge = t.number_or("surcharge", 0, dimension::pressure, not_negative);
  g.tolerance = t.number_or("tolerance", g.tolerance, dimension::none, {0, 0.2});
  for (std::size_t k = 0; k < 3; ++k)
    if (k != axis && scene.gravity[k] != 0) t.fail("axis", "gravity acts along another axis");
  if (scene.gravity[axis] > 0) t.fail("axis", "gravity acts away from the ground");
  if (g.surcharge == 0 && (scene.gravity[axis] == 0 || g.surface <= scene.low[axis]))
    t.fail("surcharge",
           "needs a surcharge, or gravity and a surface above the mesh's lowest point: there would be no stress");
  t.finish();
  scene.ground = g;
}

/// Elements that a band of softening takes up at least, which is some eleven lengths wide.
void read_regularisation(Table t, BvpScene& scene) {
  if (!scene.explicit_statics) t.fail("", "needs solve.kind = \"explicit-quasi-static\"");
  if (!scene.has_rve) t.fail("", "needs points with grains ([rve]); elastic and J2 regions are left as they are");
  fem::Regularisation by;
  by.length = t.number("length", dimension::length, positive);
  double size = 0;
  for (std::size_t k = 0; k < 3; ++k) size = std::max(size, scene.high[k] - scene.low[k]);
  if (by.length > size) t.fail("length", fmt::format("longer than the body, whose longest side is {:.3g} m", size));
  by.memory = t.number_or("memory", by.memory, dimension::none, positive);
  t.finish();
  constexpr double band = 11, least = 4;
  if (least * scene.element > band * by.length)
    scene.notes.push_back(fmt::format(
        "regularisation.length = {:.3g} m: a band of some {:.0f} lengths takes up fewer than {:.0f} elements "
        "of {:.3g} m, whose size would still decide its width; more elements or a larger length",
        by.length, band, least, scene.element));
  constexpr double narrow = 4;  // where it softens fast
  if (narrow * by.length > size)
    scene.notes.push_back(fmt::format(
        "regularisation.length = {:.3g} m: a band of {:.0f} lengths or more has no room in a body of {:.3g} m, whose "
        "load the regularisation would bear in part; a shorter length",
        by.length, narrow, size));
  scene.regularisation = by;
}

/// Something of the mesh stands under a stress when the run begins.
bool begins_stressed(const BvpScene& scene) {
  return scene.ground || (scene.has_rve && scene.unit_cells[0].recipe.preparation) ||
         std::any_of(scene.regions.begin(), scene.regions.end(),
                     [](const Region& r) { return r.initial_stress.has_value(); });
}

/// Whoever gives no history may have meant a pressure that is there from the start.
void note_ramps(BvpScene& scene) {
  if (!begins_stressed(scene)) return;
  for (std::size_t k = 0; k < scene.boundaries.size(); ++k) {
    const fem::BoundaryCondition& b = scene.boundaries[k];
    if (!(b.pressure.value_or(0) > 0) || scene.record->at("boundary")[k].contains("history")) continue;
    scene.notes.push_back(fmt::format(
        "boundary \"{}\": no history is given, so its pressure grows from 0 to {:.4g} MPa in the run, while "
        "what it presses begins under stress: history = \"constant\" for a pressure that is there from the "
        "start, \"ramp\" for one that grows",
        b.name, *b.pressure / 1e6));
  }
}

/// What moves or presses at once would strike the mesh like a hammer.
void check_eased(const Table& t, const BvpScene& scene) {
  const bool stressed = begins_stressed(scene);
  for (const auto& b : scene.boundaries) {
    const double first = b.history.at(0);
    if (first == 0) continue;
    for (const auto& u : b.displacement)
      if (u.value_or(0) != 0)
        t.fail("boundary",
               fmt::format("\"{}\": its displacement is not eased in: the history begins with {:g} instead of 0",
                           b.name, first));
    if ((b.traction || b.pressure.value_or(0) != 0) && !stressed)
      t.fail("boundary",
             fmt::format(
                 "\"{}\": nothing stands under this load at the start: ease it in (history) or give an initial stress",
                 b.name));
  }
}

}  // namespace

BvpScene read_bvp_scene(const std::string& file, const std::vector<std::string>& overrides) {
  BvpScene scene;
  scene.file = file;
  const toml::table parsed = parse_scene(file, overrides);
  const auto record = std::make_shared<nlohmann::json>();
  scene.record = record;
  Table t(parsed, file, "", *record);
  scene.title = t.text_or("title", std::filesystem::path(file).stem().string());
  read_mesh(t.table("mesh"), scene);
  if (auto e = t.table_if("element")) {
    using Element = fem::ElementKind;
    const std::string kind = e->choice_or("kind", "standard", {"standard", "fbar", "serendipity"});
    if (kind == "fbar") scene.discretisation.element = Element::fbar;
    if (kind == "serendipity") scene.discretisation.element = Element::serendipity;
    const int usual = kind == "serendipity" ? 2 : 1;
    scene.discretisation.order = static_cast<int>(e->integer_or("order", usual, 1, 2));
    if (kind != "standard" && scene.discretisation.order != usual)
      e->fail("order", fmt::format("elements of kind \"{}\" have order {}", kind, usual));
    if (kind != "standard" && !scene.bricks())
      e->fail("kind", fmt::format("\"{}\" is for quadrilaterals and hexahedra", kind));
    scene.discretisation.quadrature_degree = static_cast<int>(e->integer_or("quadrature_degree", 2, 1, 10));
    e->finish();
  }
  read_solve(t.table("solve"), scene);
  if (t.has("gravity")) read_gravity(t, scene);
  if (auto g = t.table_if("initial_stress")) read_ground(*g, scene);
  if (scene.dynamics) scene.dynamics->output_interval = scene.dynamics->duration / 200;
  for (auto& b : t.tables("boundary")) read_boundary(b, scene, scene.dynamics ? dimension::time : dimension::none);
  if (scene.boundaries.empty()) t.fail("", "needs at least one [[boundary]]");
  for (auto& r : t.tables("region")) read_region(r, scene);
  for (auto& p : t.tables("probe")) read_probe(p, scene);
  if (auto o = t.table_if("output")) read_output(*o, scene);
  if (auto h = t.table_if("hopkinson")) read_hopkinson(*h, scene);
  if (t.has("rve") || scene.regions.empty()) read_rve(t.table("rve"), scene);
  if (scene.ground && scene.has_rve && !scene.unit_cells[0].recipe.preparation)
    t.fail("initial_stress",
           fmt::format("the RVEs of {} have no [preparation] to start from", scene.unit_cells[0].file));
  if (auto r = t.table_if("regularisation")) read_regularisation(*r, scene);
  if (scene.explicit_statics) check_eased(t, scene);
  t.finish();
  for (std::size_t r = 0; r < scene.regions.size(); ++r)
    if (scene.regions[r].poissons_ratio > 0.45 && scene.discretisation.order == 1 &&
        scene.discretisation.element == fem::ElementKind::standard)
      scene.notes.push_back(
          fmt::format("region[{}].poissons_ratio = {:g} with element.order = 1: such elements lock, far too stiff in "
                      "bending and shear; element.kind = \"fbar\" or element.order = 2 helps",
                      r, scene.regions[r].poissons_ratio));
  if (scene.solve.tolerance < scene.residual_floor() && record->at("solve").contains("tolerance"))
    scene.notes.push_back(
        fmt::format("the residual is asked to fall to {:.2g}, what the RVEs' own equilibrium leaves "
                    "(rve.unbalanced_force, rve.stress_change), not to solve.tolerance = {:.2g}",
                    scene.residual_floor(), scene.solve.tolerance));
  note_size(scene);
  note_ramps(scene);
  for (const RveScene& cell : scene.unit_cells)  // of variants, which differ by their seed, once
    for (const std::string& note : cell.notes)
      if (std::find(scene.notes.begin(), scene.notes.end(), "unit cell: " + note) == scene.notes.end())
        scene.notes.push_back("unit cell: " + note);
  return scene;
}

}  // namespace grus::app
