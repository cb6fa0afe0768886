// SPDX-License-Identifier: LGPL-3.0-or-later
// [material.*] and [numerics].
#include "apps/scene/cleavage_scene.hpp"
#include "apps/scene/engine_scene.hpp"
#include "apps/scene/hulls_scene.hpp"
#include "apps/scene/jkr_scene.hpp"
#include "apps/scene/peridynamics_scene.hpp"
#include "apps/scene/reader.hpp"
#include "apps/scene/rods_scene.hpp"
#include "dem/fracture/apollonian.hpp"
#include "dem/fracture/split_polyellipsoid.hpp"

#include <fmt/format.h>

namespace grus::app {
namespace {

dem::Halves read_halves(Table& t) {
  dem::Halves halves;
  halves.turn_spheres = t.flag_or("turn_to_plane", false);
  halves.slight_rotation = t.number_or("slight_rotation", 0, dimension::angle, {0, std::atan(0.2) * (1 + 1e-4)});
  halves.rounding = t.number_or("rounding", halves.rounding, dimension::none, {0, 0.5});
  if (halves.rounding > 0 && halves.rounding < dem::least_rounding)
    t.fail("rounding",
           fmt::format("{:g}: either 0 (exact halves) or {:g} to 0.5", halves.rounding, dem::least_rounding));
  halves.keep_mass = t.choice_or("lost_mass", "fines", {"fines", "density"}) == "density";
  return halves;
}

dem::Balls read_balls(Table& t) {
  for (const char* key :
       {"turn_to_plane", "slight_rotation", "rounding", "break_plane", "cohesive_springs", "shape_transition"})
    if (t.has(key)) t.fail(key, "is for model = \"polyellipsoid-split\": between fourteen balls there is no plane");
  const std::string lost = t.choice_or("lost_mass", "fines", {"fines", "density", "swell"});
  return {lost != "fines", lost == "swell"};
}

dem::ContactStrength read_contact_strength(Table& t, double poissons_ratio, const std::string& own_area) {
  dem::ContactStrength c;
  if (t.has("strength") == t.has("compressive_strength"))
    t.fail("", "needs either strength, or compressive_strength and tensile_strength");
  if (t.has("strength")) {
    c.strength = t.number("strength", dimension::pressure, positive);
  } else {
    const double compressive = t.number("compressive_strength", dimension::pressure, positive);
    const double tensile = t.number("tensile_strength", dimension::pressure, {0, compressive, true, true});
    c.strength = dem::ContactStrength::limit(compressive, tensile, poissons_ratio);
  }
  if (t.choice("area", {"angle", own_area}) == "angle")
    c.angle = t.number("angle", dimension::angle, {0, 0.5 * dem::pi, true});
  else if (t.has("angle"))
    t.fail("angle", "is for area = \"angle\"");
  t.finish();
  return c;
}

dem::Scatter read_scatter(Table& t) {
  dem::Scatter s;
  s.normal = t.choice_or("distribution", "log-normal", {"log-normal", "normal"}) == "normal";
  s.variation = t.number_or("variation", 0, dimension::none, {0, 2});
  s.size_exponent = t.number_or("size_exponent", 0, dimension::none, not_negative);
  if (s.size_exponent > 0 || t.has("reference_diameter"))
    s.reference_diameter = t.number("reference_diameter", dimension::length, positive);
  else
    s.reference_diameter = 1;
  t.finish();
  return s;
}

/// Criteria that ask for Hertz's circle of contact.
bool needs_hertz(const dem::Criterion& c) {
  const auto* strength = std::get_if<dem::ContactStrength>(&c);
  return std::holds_alternative<dem::ContactTension>(c) || (strength && !strength->angle);
}

/// What only halves have: planes, springs across them, shapes that recover.
void read_halving(Table& t, dem::FractureModel& f) {
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
  if (auto s = t.table_if("shape_transition")) {
    dem::ShapeTransition transition;
    transition.ratio = s->number_or("ratio", transition.ratio, dimension::none, {0.2, 1, true});
    transition.time = s->number_or("time", transition.time, dimension::time, positive);
    f.transition = transition;
    s->finish();
  }
}

/// How strengths scatter.
void read_scattering(Table& t, dem::StrengthLaw& law) {
  if (t.has("weibull") && t.has("scatter")) t.fail("scatter", "a material has either weibull or scatter");
  if (auto s = t.table_if("scatter")) law = read_scatter(*s);
  if (auto w = t.table_if("weibull")) {
    dem::Weibull weibull;
    weibull.modulus = w->number("modulus", dimension::none, positive);
    weibull.reference_radius = w->number("reference_radius", dimension::length, positive);
    weibull.size_exponent = w->number_or("size_exponent", 3 / weibull.modulus, dimension::none, not_negative);
    weibull.linear = w->choice_or("law", "weibull", {"weibull", "linear"}) == "linear";
    weibull.inherits = w->flag_or("inherit", false);
    law = weibull;
    w->finish();
  }
}

/// Criteria of all models but for those of one alone.
void read_strength(Table& t, dem::FractureModel& f, double poissons_ratio, const std::string& own_area) {
  if (auto h = t.table_if("hoek_brown")) {
    f.criteria.emplace_back(dem::HoekBrown{h->number("compressive_strength", dimension::pressure, positive),
                                           h->number("m", dimension::none, positive)});
    h->finish();
  }
  if (auto c = own_area == "hertz" ? t.table_if("contact_tension") : std::nullopt) {
    f.criteria.emplace_back(
        dem::ContactTension{c->number("strength", dimension::pressure, positive),
                            static_cast<int>(c->integer_or("critical_contacts", 3, 3, dem::most_critical_contacts))});
    c->finish();
  }
  if (auto c = t.table_if("contact_strength"))
    f.criteria.emplace_back(read_contact_strength(*c, poissons_ratio, own_area));
}

void read_limit(Table& t, int rest, dem::Limit& limit) {
  limit.smallest_radius = t.number_or("smallest_radius", 0, dimension::length, not_negative);
  limit.max_generations = static_cast<int>(t.integer_or("max_generations", 255, 0, 255));
  limit.rest = static_cast<int>(t.integer_or("rest", rest, 0, 1000000));
}

dem::FractureModel read_fracture(Table t, const dem::Material& material,
                                 const std::optional<dem::Elasticity>& elasticity) {
  const std::string model =
      t.choice("model", {"polyellipsoid-split", "apollonian-14", "bonded", "cleavage", "peridynamics"});
  if (model == "bonded")
    t.fail("model",
           "\"bonded\" is not available in this version; use \"polyellipsoid-split\", \"apollonian-14\" or, of "
           "hulls, \"cleavage\" or \"peridynamics\"");
  dem::FractureModel f;
  const bool balls = model == "apollonian-14", hulls = model == "cleavage";
  read_scattering(t, f.strength_law);
  if (model == "peridynamics") {
    read_peridynamics(t, material, elasticity, f);
    read_limit(t, 0, f.limit);
    t.finish();
    return f;
  }
  read_strength(t, f, material.poissons_ratio, hulls ? "contact" : "hertz");
  if (hulls) {
    read_cleavage(t, elasticity, f);
    read_limit(t, 0, f.limit);
    t.finish();
    return f;
  }
  if (f.criteria.empty())
    t.fail("", "needs hoek_brown, contact_tension or contact_strength: without a criterion nothing breaks");
  if (balls) {
    f.splitter = read_balls(t);
    f.fines.largest = dem::smallest_ball();
  } else {
    read_halving(t, f);
  }
  if (auto g = t.table_if("fines")) read_fines(*g, balls, f.fines);
  read_limit(t, balls ? 20 : 0, f.limit);
  t.finish();
  return f;
}

/// What hulls press with, and the bonds of their faces: contacts of matching Voronoi cells are as stiff as the bonds
/// were.
std::optional<dem::Elasticity> read_overlap(Table& t, dem::Material& m, std::optional<bool>& given) {
  std::optional<dem::Elasticity> elasticity;
  if (auto b = t.table_if("bond")) m.bond = read_bond(*b, m.friction, elasticity);
  if (t.has("foundation") && t.has("youngs_modulus")) t.fail("foundation", "needs either foundation or youngs_modulus");
  const bool by_bond = m.bond && !t.has("youngs_modulus") && !t.has("foundation");
  const bool now = by_bond ? m.bond->stiffness_given : t.has("foundation");
  if (given && *given != now)
    t.fail("foundation", "either all materials of a scene tell their stiffness per area, or all tell a modulus");
  given = now;
  dem::Foundation::Of own;
  double& told = now ? own.given : own.modulus;
  if (by_bond)
    told = m.bond->stiffness;
  else if (now)
    told = t.number("foundation", dimension::foundation, positive);
  else
    told = t.number("youngs_modulus", dimension::pressure, positive);
  if (!by_bond && !now) elasticity = {told, m.poissons_ratio};
  own.shear_ratio = t.number_or("shear_ratio", m.bond ? m.bond->ratio : 2.0 / 7, dimension::none, not_negative);
  m.contact = own;
  return elasticity;
}

/// What of it is given; a step that grains are given inertia for is neither held nor bounded from above.
void read_inertia(Table& t, dem::Numerics& n) {
  if (!t.has("scaled_below") && !t.has("step")) t.fail("", "needs scaled_below or step");
  if (t.has("scaled_below")) n.scaled_below = t.number("scaled_below", dimension::length, positive);
  if (t.has("step")) {
    n.inertia_step = t.number("step", dimension::time, positive), n.place_of_step = t.place("step");
    if (n.time_step > 0) t.fail("step", "is for steps that follow from the grains: leave out numerics.time_step");
    if (n.max_time_step > 0 && n.max_time_step < n.inertia_step)
      t.fail("step", fmt::format("{:.4g} s: above numerics.max_time_step, {:.4g} s", n.inertia_step, n.max_time_step));
  }
  t.finish();
}

}  // namespace

void read_fines(Table& t, bool balls, dem::FinesGrading& fines) {
  fines.dimension = t.number_or("dimension", fines.dimension, dimension::none, {0, 3, false, true});
  if (balls && (!t.has("largest") || t.is_text("largest")))
    t.choice_or("largest", "fragment", {"fragment"});  // as it is
  else
    fines.largest = t.number_or("largest", fines.largest, dimension::none, {0, 1, true});
  fines.smallest = t.number_or("smallest", 0, dimension::length, not_negative);
  t.finish();
}

void read_model(Table& scene, dem::Model& model, bool unit_cell) {
  Table materials = scene.table("material");
  std::string law;
  std::optional<bool> foundation;  // of hulls: it is given, or follows from a modulus
  for (const auto& name : materials.table_names()) {
    Table t = materials.table(name);
    dem::Material m;
    m.name = name;
    m.density = t.number("density", dimension::density, positive);
    const std::string kind =
        t.choice_or("contact", "hertz-mindlin", {"hertz-mindlin", "jkr", "linear", "linear-modulus", "overlap"});
    if (!law.empty() && law != kind) t.fail("contact", "all materials of a scene share one contact law");
    law = kind;
    std::optional<dem::Elasticity> elasticity;
    m.poissons_ratio = t.number_or("poissons_ratio", 0.25, dimension::none, {0, 0.5, false, true});
    if (kind == "hertz-mindlin") {
      m.youngs_modulus = t.number("youngs_modulus", dimension::pressure, positive);
    } else if (kind == "jkr") {
      read_jkr(t, m);
    } else if (kind == "overlap") {
      m.friction = t.number_or("friction", 0, dimension::none, not_negative);
      elasticity = read_overlap(t, m, foundation);
    } else {
      dem::LinearSpring::Of own;
      if (kind == "linear")
        own.stiffness = t.number("normal_stiffness", dimension::stiffness, positive);
      else
        own.modulus = t.number("contact_modulus", dimension::pressure, positive);
      own.shear_ratio = t.number_or("shear_ratio", 2.0 / 7, dimension::none, not_negative);
      m.contact = own;
      m.youngs_modulus = t.number_or("youngs_modulus", 60e9, dimension::pressure, positive);
    }
    if (kind != "overlap") m.friction = t.number_or("friction", 0, dimension::none, not_negative);
    m.restitution = t.number_or("restitution", 1, dimension::none, {0.01, 1});
    m.damping = t.number_or("damping", 0, dimension::none, {0, 1, false, true});
    m.turns = t.flag_or("rotation", true);
    m.rolling_friction = t.number_or("rolling_friction", 0, dimension::none, not_negative);
    if (m.rolling_friction > 0) {
      if (kind == "overlap") t.fail("rolling_friction", "contact = \"overlap\": hulls roll as their faces let them");
      if (m.friction == 0) t.fail("rolling_friction", "needs friction: what slides freely does not roll");
      if (!m.turns) t.fail("rolling_friction", "rotation = false: its grains do not turn");
    }
    if (auto f = t.table_if("fracture")) {
      m.fracture = read_fracture(*f, m, elasticity);
      if (m.fracture->of_hulls() && kind != "overlap")
        t.fail("fracture",
               "model = \"cleavage\" cuts hulls, \"peridynamics\" cracks them: needs contact = \"overlap\"");
    }
    if (auto b = kind == "overlap" ? std::nullopt : t.table_if("bond")) {
      refuse_rods(t, m, kind);
      m.bond = read_rods(*b);
    }
    t.finish();
    model.materials.push_back(m);
  }
  materials.finish();
  if (model.materials.empty()) scene.fail("material", "needs at least one [material.NAME] table");
  if (model.materials.size() > 200) scene.fail("material", "at most 200 materials");
  if (law == "overlap") {
    model.law = dem::Foundation{};
  } else if (law == "jkr") {
    model.law = dem::Jkr{};
  } else if (law != "hertz-mindlin") {
    model.law = dem::LinearSpring{};
    // Force over the square of Hertz's contact radius does not depend on the force here: it breaks at none or never.
    for (const auto& m : model.materials)
      if (m.fracture && std::any_of(m.fracture->criteria.begin(), m.fracture->criteria.end(), needs_hertz))
        materials.fail(m.name,
                       fmt::format("fracture.contact_tension, and contact_strength with area = \"hertz\", have no "
                                   "meaning with contact = \"{}\", whose stress in the contact does not grow with the "
                                   "load; use hoek_brown, area = \"angle\", or \"hertz-mindlin\"",
                                   law));
  }

  dem::Numerics& n = model.numerics;
  if (unit_cell) n.safety = unit_cell_safety(model);
  if (auto t = scene.table_if("numerics")) {
    n.safety = t->number_or("safety", n.safety, dimension::none, {0, 1, true});
    n.time_step = t->number_or("time_step", 0, dimension::time, not_negative);
    n.max_time_step = t->number_or("max_time_step", 0, dimension::time, not_negative);
    if (n.time_step > 0 && n.max_time_step > 0)
      t->fail("max_time_step", "bounds nothing beside time_step, which holds");
    n.skin = t->number_or("skin", n.skin, dimension::none, {0.001, 2});
    n.estimate_every = static_cast<int>(t->integer_or("estimate_every", n.estimate_every, 1, 1000000));
    n.fracture_every = static_cast<int>(t->integer_or("fracture_every", n.fracture_every, 1, 100000));
    n.max_energy_error = t->number_or("max_energy_error", n.max_energy_error, dimension::none, positive);
    if (auto inertia = t->table_if("inertia")) read_inertia(*inertia, n);
    if (t->choice_or("engine", "explicit", {"explicit", "implicit"}) == "implicit")
      read_implicit(*t, model, unit_cell);
    else if (t->has("compliance"))
      t->fail("compliance", "is of engine = \"implicit\"");
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
