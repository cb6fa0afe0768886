// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/engine_scene.hpp"

#include <fmt/format.h>

#include "apps/scene/reader.hpp"
#include "dem/rve/implicit_stepper.hpp"
#include "dem/rve/rigid_stepper.hpp"

namespace grus::app {
namespace {

constexpr const char* driven =
    "drives a boundary, which grains that do not give way (numerics.compliance = 0) bear without bound: use "
    "[[stage]] of kind \"deposit\" or \"relax\" with gravity";

/// What of a material implicit steps do not know; nullptr: nothing.
const char* beyond(const dem::Material& m) {
  if (m.rolling_friction > 0) return "rolling_friction";
  if (m.damping > 0) return "damping (its steps need none)";
  if (m.bond) return "bonds";
  if (!m.turns) return "rotation = false";
  if (!m.fracture) return nullptr;
  const dem::FractureModel& f = *m.fracture;
  if (f.springs) return "springs across fresh planes (fracture.cohesive_springs)";
  if (f.transition) return "fragments that grow back (fracture.shape_transition)";
  if (std::holds_alternative<dem::Balls>(f.splitter)) return "grains that break into balls";
  const auto* cut = std::get_if<dem::Cut>(&f.splitter);
  return cut && cut->cohesive ? "fracture with cohesive = true, whose fresh faces are bonded" : nullptr;
}

/// numerics.compliance = 0: true.
bool read_rigid(Table& t, const dem::Model& model) {
  const char* const key = "compliance";
  const double compliance = t.number_or(key, 1, dimension::none, {0, 1});
  if (compliance == 1) return false;
  if (compliance != 0) t.fail(key, "is 1, that of the contact law, or 0: grains that do not give way");
  if (!std::holds_alternative<dem::Foundation>(model.law)) t.fail(key, "0 is for hulls (contact = \"overlap\")");
  if (model.breakable()) t.fail(key, "0 is for grains that do not break: which contact bears how much would be chance");
  return true;
}

}  // namespace

void read_implicit(Table& t, dem::Model& model, bool unit_cell) {
  const char* const key = "engine";
  if (unit_cell) t.fail(key, "\"implicit\" is for tests of grus-rve: cells of macro problems take explicit steps");
  if (model.numerics.scales_inertia()) t.fail(key, "\"implicit\" needs no numerics.inertia: leave that out");
  if (attracts(model.law)) t.fail(key, "\"implicit\" knows no contacts that attract (contact = \"jkr\")");
  for (const dem::Material& m : model.materials)
    if (const char* what = beyond(m)) t.fail(key, fmt::format("\"implicit\" knows no {}: material {}", what, m.name));
  const bool rigid = read_rigid(t, model);
  model.stepper = rigid ? &dem::rigid_stepper : &dem::implicit_stepper, model.numerics.place_of_step = t.place(key);
}

void check_implicit(Table& t, const dem::Model& model, dem::TestKind kind) {
  using Kind = dem::TestKind;
  if (kind == Kind::free || kind == Kind::platens || kind == Kind::rollers)
    t.fail("kind", "is of real time, which numerics.engine = \"implicit\" damps away: use \"explicit\"");
  if (model.stepper == &dem::rigid_stepper) t.fail("kind", driven);
}

void check_rigid(Table& t, const dem::Model& model, bool stands) {
  if (!stands && model.stepper == &dem::rigid_stepper) t.fail("kind", driven);
}

std::optional<std::string> note_of_rigid(const dem::Model& model) {
  if (model.stepper != &dem::rigid_stepper) return {};
  return "numerics.compliance = 0: grains do not give way, so that the forces of their contacts are not unique (sums "
         "are); blows are without rebound";
}

}  // namespace grus::app
