// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/peridynamics_scene.hpp"
#include "apps/scene/reader.hpp"
#include "dem/fracture/platens.hpp"

#include <fmt/format.h>

namespace grus::app {
namespace {

dem::LatticeChoice read_lattice(Table& t) {
  dem::LatticeChoice c;
  c.points = static_cast<int>(t.integer_or("points", c.points, 300, 20000));
  c.horizon = t.number_or("horizon", c.horizon, dimension::none, {2, 6});
  c.partial_volume = t.flag_or("partial_volume", c.partial_volume);
  c.patch = t.number_or("patch", c.patch, dimension::none, {0.03, 0.3});
  c.turned = t.choice_or("lattice", "random", {"random", "aligned"}) == "random";
  return c;
}

/// Either the strength between platens or an energy; the other follows.
void read_toughness(Table& t, const dem::StrengthLaw& law, dem::CrackTests& c, dem::PlatenForce& platens) {
  dem::LatticeToughness& toughness = c.toughness;
  if (t.choice_or("toughness_form", "all-bonds", {"all-bonds", "madenci-oterkus"}) == "madenci-oterkus")
    toughness.form = dem::Toughness::madenci_oterkus;
  if (t.has("platen_strength") == t.has("fracture_energy"))
    t.fail("", "needs either platen_strength or fracture_energy");
  if (t.has("platen_strength") && t.has("toughness_form"))
    t.fail("toughness_form",
           "says what fracture_energy is worth; beside platen_strength it changes nothing: leave it out");
  const auto* weibull = std::get_if<dem::Weibull>(&law);
  if (t.has("platen_strength"))
    toughness.reference_diameter = 1;  // the energy that follows is not told
  else if (weibull && !t.has("reference_diameter"))
    toughness.reference_diameter = 2 * weibull->reference_radius;
  else
    toughness.reference_diameter = t.number("reference_diameter", dimension::length, positive);
  const dem::LatticeModel& l = c.lattice;
  const double number = dem::platen_number(l);
  const auto horizon = l.lattice.horizon * l.lattice.spacing() * toughness.reference_diameter;
  if (t.has("platen_strength")) {
    platens.strength = t.number("platen_strength", dimension::pressure, positive);
    toughness.energy = dem::fracture_energy(toughness.form, platens.strength / (number * l.youngs_modulus),
                                            l.youngs_modulus, l.poissons_ratio, horizon);
  } else {
    toughness.energy = t.number("fracture_energy", dimension::surface_energy, positive);
    platens.strength =
        number * l.youngs_modulus *
        dem::critical_stretch(toughness.form, toughness.energy, l.youngs_modulus, l.poissons_ratio, horizon);
  }
  if (!(platens.strength < 0.01 * l.youngs_modulus))
    t.fail("", fmt::format("grains of {:.3g} Pa: more than a hundredth of youngs_modulus, for which displacements are "
                           "not small",
                           platens.strength));
}

/// Griffith's law beside what the strengths' own law says: F/d^2 falls with the square root of the size.
void read_size_law(Table& t, dem::StrengthLaw& law) {
  if (t.choice_or("size_law", "reference-horizon", {"reference-horizon", "griffith"}) == "reference-horizon") return;
  constexpr double griffith = 0.5;
  if (auto* weibull = std::get_if<dem::Weibull>(&law)) {
    if (t.has("reference_diameter"))
      t.fail("reference_diameter", "with size_law = \"griffith\" it is twice weibull.reference_radius; leave it out");
    weibull->size_exponent += griffith;
    return;
  }
  const double reference = t.number("reference_diameter", dimension::length, positive);
  auto* scatter = std::get_if<dem::Scatter>(&law);
  if (!scatter)
    law = dem::Scatter{.reference_diameter = reference, .size_exponent = griffith};
  else if (scatter->size_exponent > 0 && scatter->reference_diameter != reference)
    t.fail("reference_diameter", "with size_law = \"griffith\" it is that of scatter");
  else
    scatter->reference_diameter = reference, scatter->size_exponent += griffith;
}

/// Where clusters go that are too small for a piece.
void read_small_pieces(Table& t, dem::LatticeModel& lattice, dem::FinesGrading& fines) {
  lattice.crumbs = t.choice_or("small_pieces", "attach", {"attach", "fines"}) == "fines";
  if (!lattice.crumbs) return;
  fines.largest = std::cbrt(lattice.smallest_piece);
  if (auto g = t.table_if("fines")) read_fines(*g, false, fines);
}

void read_tests(Table& t, dem::CrackTests& c) {
  c.force_screen = t.number_or("force_screen", c.force_screen, dimension::none, {0, 1});
  c.lattice.core_screen = t.number_or("core_screen", c.lattice.core_screen, dimension::none, {0, 1});
  c.unbalanced_force = t.number_or("unbalanced_force", c.unbalanced_force, dimension::none, positive);
  c.unbalanced_moment = t.number_or("unbalanced_moment", c.unbalanced_moment, dimension::none, positive);
  c.changed_force = t.number_or("changed_force", c.changed_force, dimension::none, {0, 1});
  t.finish();
}

}  // namespace

void read_peridynamics(Table& t, const dem::Material& material, const std::optional<dem::Elasticity>& elasticity,
                       dem::FractureModel& f) {
  if (material.bond)
    t.fail("model",
           "\"peridynamics\" goes with no bonds: what holds grains together is not cut with them; leave "
           "out bond, or use \"cleavage\"");
  if (!elasticity)
    t.fail("model",
           "\"peridynamics\" needs contact = \"overlap\", of hulls, with youngs_modulus: what the points of a "
           "grain pull with");
  dem::CrackTests c;
  c.lattice.lattice = read_lattice(t);
  c.lattice.youngs_modulus = elasticity->modulus, c.lattice.poissons_ratio = elasticity->poissons_ratio;
  c.lattice.keep_patches = t.flag_or("keep_patches", c.lattice.keep_patches);
  dem::PlatenForce platens;
  read_toughness(t, f.strength_law, c, platens);
  read_size_law(t, f.strength_law);
  c.lattice.smallest_piece = t.number_or("smallest_piece", c.lattice.smallest_piece, dimension::none, {0.001, 0.3});
  read_small_pieces(t, c.lattice, f.fines);
  dem::Shatter shatter;
  shatter.parting.least_stoutness =
      t.number_or("stoutness", shatter.parting.least_stoutness, dimension::none, {0, 0.4});
  if (auto r = t.table_if("crack")) {
    c.lattice.damping = r->number_or("damping", c.lattice.damping, dimension::none, {0, 100});
    c.lattice.time = r->number_or("time", c.lattice.time, dimension::none, {0, 100});
    r->finish();
  }
  if (auto s = t.table_if("test")) read_tests(*s, c);
  f.criteria.emplace_back(platens);
  f.splitter = shatter;
  f.cracks = c;
}

}  // namespace grus::app
