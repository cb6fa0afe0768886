// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/cleavage_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include "apps/scene/packing_scene.hpp"

namespace grus::app {
namespace {

using dem::Vec3;

/// Reads toughnesses of families of planes, one each or one for all; the smallest is the material's.
void read_planes(Table& t, dem::Cleavage& c) {
  std::vector<double> toughness;
  const std::size_t given = t.length("toughness");
  if (given > 0)
    toughness = t.numbers("toughness", given, dimension::toughness);
  else
    toughness.push_back(t.number("toughness", dimension::toughness, positive));
  for (const double k : toughness)
    if (!(k > 0)) t.fail("toughness", "must be above 0");
  c.toughness = *std::min_element(toughness.begin(), toughness.end());
  if (t.has("planes"))
    for (const auto& p : t.points("planes", dimension::none)) {
      const Vec3 n(p[0], p[1], p[2]);
      if (!(n.norm() > 0)) t.fail("planes", "are normals, not zero");
      if (c.planes.size() >= 32) t.fail("planes", "32 at most");
      c.planes.push_back({n.normalized(), toughness[std::min(c.planes.size(), toughness.size() - 1)]});
    }
  if (toughness.size() > 1 && toughness.size() != c.planes.size())
    t.fail("toughness", fmt::format("one for all, or one for each of the {} planes", c.planes.size()));
}

void read_offsets(Table& t, dem::Cleavage& c) {
  if (!t.has("offsets")) return;
  const std::size_t count = t.length("offsets");
  if (count == 0 || count > 32) t.fail("offsets", "expected a list of 1 to 32 numbers");
  c.offsets = t.numbers("offsets", count, dimension::none);
  for (const double x : c.offsets)
    if (!(std::abs(x) < 1)) t.fail("offsets", "are between -1 and 1, of the way from the mass centre to the surface");
}

/// "random" (the default), "aligned", or {axis, angles}.
dem::Crystal read_crystal(Table& t) {
  dem::Crystal crystal;
  if (!t.has("crystal") || t.is_text("crystal")) {
    if (t.choice_or("crystal", "random", {"random", "aligned"}) == "aligned")
      crystal.axis = Vec3::UnitZ(), crystal.angles = {0.0};
    return crystal;
  }
  Table c = t.table("crystal");
  const Vec3 axis = vector3(c.numbers("axis", 3, dimension::none));
  if (!(axis.norm() > 0)) c.fail("axis", "must not be zero");
  const std::size_t count = c.length("angles");
  if (count == 0 || count > 1000) c.fail("angles", "expected a list of angles");
  crystal.axis = axis.normalized(), crystal.angles = c.numbers("angles", count, dimension::angle);
  c.finish();
  return crystal;
}

}  // namespace

void read_cleavage(Table& t, const std::optional<dem::Elasticity>& elasticity, dem::FractureModel& f) {
  std::optional<double> energy;
  if (t.has("toughness")) {
    dem::Cleavage c;
    read_planes(t, c);
    c.flaw = t.number("flaw", dimension::length, positive);
    c.geometry = t.number_or("geometry", c.geometry, dimension::none, positive);
    c.mode_ratio = t.number_or("mode_ratio", c.mode_ratio, dimension::none, positive);
    read_offsets(t, c);
    if (t.has("hydrostatic_gate")) c.gate = t.number("hydrostatic_gate", dimension::pressure, any);
    if (!c.planes.empty()) f.crystal = read_crystal(t);
    if (elasticity)
      energy = c.toughness * c.toughness * (1 - std::pow(elasticity->poissons_ratio, 2)) / elasticity->modulus;
    f.criteria.emplace_back(std::move(c));
  }
  if (f.criteria.empty())
    t.fail("", "needs toughness, hoek_brown or contact_strength: without a criterion nothing breaks");
  if (t.has("fracture_energy")) energy = t.number("fracture_energy", dimension::surface_energy, positive);
  dem::Cut cut;
  cut.cohesive = t.flag_or("cohesive", energy.has_value());
  if (cut.cohesive && !energy)
    t.fail("cohesive", "needs fracture_energy, or toughness and a modulus of elasticity: what the fresh face takes");
  if (cut.cohesive) cut.energy = *energy;
  f.splitter = cut;
}

}  // namespace grus::app
