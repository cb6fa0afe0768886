// SPDX-License-Identifier: LGPL-3.0-or-later
// [material.*] and [numerics].
#include "apps/scene/reader.hpp"
#include "apps/scene/rve_scene.hpp"
#include "dem/fracture/split_polyellipsoid.hpp"

#include <fmt/format.h>

namespace grus::app {
namespace {

dem::Halves read_halves(Table& t) {
  dem::Halves halves;
  halves.turn_spheres = t.flag_or("turn_to_plane", false);
  halves.slight_rotation = t.number_or("slight_rotation", 0, dimension::none, {0, std::atan(0.2) * (1 + 1e-4)});
  halves.rounding = t.number_or("rounding", halves.rounding, dimension::none, {0, 0.5});
  if (halves.rounding > 0 && halves.rounding < dem::least_rounding)
    t.fail("rounding",
           fmt::format("{:g}: either 0 (exact halves) or {:g} to 0.5", halves.rounding, dem::least_rounding));
  halves.keep_mass = t.choice_or("lost_mass", "fines", {"fines", "density"}) == "density";
  return halves;
}

dem::FractureModel read_fracture(Table t) {
  dem::FractureModel f;
  const std::string model =
      t.choice("model", {"polyellipsoid-split", "apollonian-14", "bonded", "cleavage", "peridynamics"});
  if (model != "polyellipsoid-split")
    t.fail("model", fmt::format("\"{}\" is not available in this version; use \"polyellipsoid-split\"", model));
  if (auto h = t.table_if("hoek_brown")) {
    f.criteria.emplace_back(dem::HoekBrown{h->number("compressive_strength", dimension::pressure, positive),
                                           h->number("m", dimension::none, positive)});
    h->finish();
  }
  if (auto c = t.table_if("contact_tension")) {
    f.criteria.emplace_back(
        dem::ContactTension{c->number("strength", dimension::pressure, positive),
                            static_cast<int>(c->integer_or("critical_contacts", 3, 3, dem::most_critical_contacts))});
    c->finish();
  }
  if (f.criteria.empty()) t.fail("", "needs hoek_brown, contact_tension or both: without a criterion nothing breaks");
  if (auto w = t.table_if("weibull")) {
    dem::Weibull weibull;
    weibull.modulus = w->number("modulus", dimension::none, positive);
    weibull.reference_radius = w->number("reference_radius", dimension::length, positive);
    weibull.size_exponent = w->number_or("size_exponent", 3 / weibull.modulus, dimension::none, not_negative);
    f.strength_law = weibull;
    w->finish();
  }
  if (auto s = t.table_if("cohesive_springs")) {
    dem::CohesiveSprings springs;
    springs.per_plane = static_cast<int>(s->integer_or("per_plane", 4, 3, 64));
    springs.toughness = s->number("toughness", dimension::toughness, positive);
    springs.max_opening = s->number_or("max_opening", springs.max_opening, dimension::none, {0, 1, true});
    springs.stiffness_ratio = s->number_or("stiffness_ratio", springs.stiffness_ratio, dimension::none, positive);
    f.springs = springs;
    s->finish();
  }
  const std::string plane =
      t.choice_or("break_plane", "criterion", {"criterion", "average-stress", "critical-contacts"});
  if (plane == "average-stress") f.plane = dem::BreakPlane::average_stress;
  if (plane == "critical-contacts") f.plane = dem::BreakPlane::critical_contacts;
  f.splitter = read_halves(t);
  if (auto g = t.table_if("fines")) {
    f.fines.dimension = g->number_or("dimension", f.fines.dimension, dimension::none, {0, 3, false, true});
    f.fines.largest = g->number_or("largest", f.fines.largest, dimension::none, {0, 1, true});
    g->finish();
  }
  if (auto s = t.table_if("shape_transition")) {
    dem::ShapeTransition transition;
    transition.ratio = s->number_or("ratio", transition.ratio, dimension::none, {0.2, 1, true});
    transition.time = s->number_or("time", transition.time, dimension::time, positive);
    f.transition = transition;
    s->finish();
  }
  f.limit.smallest_radius = t.number_or("smallest_radius", 0, dimension::length, not_negative);
  f.limit.max_generations = static_cast<int>(t.integer_or("max_generations", 255, 0, 255));
  t.finish();
  return f;
}

}  // namespace

void read_model(Table& scene, dem::Model& model) {
  Table materials = scene.table("material");
  std::string law;
  for (const auto& name : materials.table_names()) {
    Table t = materials.table(name);
    dem::Material m;
    m.name = name;
    m.density = t.number("density", dimension::density, positive);
    const std::string kind = t.choice_or("contact", "hertz-mindlin", {"hertz-mindlin", "linear"});
    if (!law.empty() && law != kind) t.fail("contact", "all materials of a scene share one contact law");
    law = kind;
    m.poissons_ratio = t.number_or("poissons_ratio", 0.25, dimension::none, {0, 0.5, false, true});
    if (kind == "hertz-mindlin") {
      m.youngs_modulus = t.number("youngs_modulus", dimension::pressure, positive);
    } else {
      m.normal_stiffness = t.number("normal_stiffness", dimension::stiffness, positive);
      m.shear_ratio = t.number_or("shear_ratio", 2.0 / 7, dimension::none, not_negative);
      m.youngs_modulus = t.number_or("youngs_modulus", 60e9, dimension::pressure, positive);
    }
    m.friction = t.number_or("friction", 0, dimension::none, not_negative);
    m.restitution = t.number_or("restitution", 1, dimension::none, {0.01, 1});
    m.damping = t.number_or("damping", 0, dimension::none, {0, 1, false, true});
    if (auto f = t.table_if("fracture")) m.fracture = read_fracture(*f);
    t.finish();
    model.materials.push_back(m);
  }
  materials.finish();
  if (model.materials.empty()) scene.fail("material", "needs at least one [material.NAME] table");
  if (model.materials.size() > 200) scene.fail("material", "at most 200 materials");
  if (law == "linear") {
    model.law = dem::LinearSpring{};
    // Force over the square of Hertz's contact radius does not depend on the force here: it breaks at none or never.
    for (const auto& m : model.materials)
      if (m.fracture && std::any_of(m.fracture->criteria.begin(), m.fracture->criteria.end(),
                                    [](const auto& c) { return std::holds_alternative<dem::ContactTension>(c); }))
        materials.fail(m.name,
                       "fracture.contact_tension has no meaning with contact = \"linear\", whose tension at the "
                       "contact's rim does not grow with the load; use hoek_brown, or \"hertz-mindlin\"");
  }

  dem::Numerics& n = model.numerics;
  if (auto t = scene.table_if("numerics")) {
    n.safety = t->number_or("safety", n.safety, dimension::none, {0, 1, true});
    n.time_step = t->number_or("time_step", 0, dimension::time, not_negative);
    n.max_time_step = t->number_or("max_time_step", 0, dimension::time, not_negative);
    n.skin = t->number_or("skin", n.skin, dimension::none, {0.001, 2});
    n.estimate_every = static_cast<int>(t->integer_or("estimate_every", n.estimate_every, 1, 1000000));
    n.fracture_every = static_cast<int>(t->integer_or("fracture_every", n.fracture_every, 1, 100000));
    n.max_energy_error = t->number_or("max_energy_error", n.max_energy_error, dimension::none, positive);
    n.max_overlap = t->number_or("max_overlap", model.overlap_limit(), dimension::none, {0, 10, true});
    t->finish();
  }
}

dem::QuasiStatic read_quasi_static(Table& t) {
  dem::QuasiStatic q;
  q.strain_per_step = t.number_or("strain_per_step", q.strain_per_step, dimension::none, {0, 0.01, true});
  q.inertial_number = t.number_or("inertial_number", q.inertial_number, dimension::none, {0, 0.1, true});
  q.unbalanced_force = t.number_or("unbalanced_force", q.unbalanced_force, dimension::none, {0, 1, true});
  q.stress_change = t.number_or("stress_change", q.stress_change, dimension::none, {0, 1, true});
  q.pressure_floor = t.number_or("pressure_floor", q.pressure_floor, dimension::pressure, not_negative);
  q.window = static_cast<int>(t.integer_or("window", q.window, 1, 100000));
  q.max_hold = static_cast<std::uint64_t>(t.integer_or("max_hold", static_cast<long>(q.max_hold), 1, 1000000000));
  return q;
}

}  // namespace grus::app
