// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/supports_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include "apps/scene/packing_scene.hpp"
#include "apps/scene/sample_scene.hpp"
#include "apps/scene/speeds.hpp"

namespace grus::app {
namespace {

using dem::Vec3;

/// "x=min": the direction outwards.
Vec3 direction_of(Table& t) {
  const std::string where = t.choice("where", {"x=min", "x=max", "y=min", "y=max", "z=min", "z=max"});
  Vec3 d = Vec3::Zero();
  d[where[0] - 'x'] = where.substr(2) == "min" ? -1 : 1;
  return d;
}

void needs_cells(const Table& t, const RveScene& scene) {
  if (!scene.recipe.of_voronoi()) t.fail("", "needs Voronoi cells to hold on to: packing.kind = \"voronoi\"");
}

/// One Voronoi cell alone has no bond, and yet holds on to what it is glued to.
bool holds_on(const RveScene& scene) {
  const auto* cells = dem::voronoi_material(scene.recipe);
  return cells && scene.model.materials[*cells].bond;
}

void read_clamp(Table t, RveScene& scene) {
  auto& clamps = scene.recipe.supports.clamps;
  dem::Clamp clamp{.outward = direction_of(t), .place = t.place("where")};
  needs_cells(t, scene);
  if (!holds_on(scene)) t.fail("", "needs [material.NAME.bond], by which Voronoi cells hold on");
  for (const dem::Clamp& other : clamps)
    if (other.outward == clamp.outward) t.fail("where", "is clamped twice");
  clamp.velocity = read_velocity(t, scene.model);
  clamp.material = rigid_material(t, scene.model, NAN);
  clamp.slides = t.flag_or("slides", false);
  clamps.push_back(clamp);
  t.finish();
}

void read_load(Table t, RveScene& scene) {
  dem::EndLoad load{.outward = direction_of(t), .place = t.place("where")};
  needs_cells(t, scene);
  load.force = vector3(t.numbers("force", 3, dimension::force));
  load.ramp = t.number_or("ramp", 0, dimension::time, not_negative);
  scene.recipe.supports.loads.push_back(load);
  t.finish();
}

}  // namespace

bool open_and_free(const RveScene& scene) {
  const dem::Recipe& r = scene.recipe;
  return r.bounds == dem::Bounds::open && r.walls.empty() && r.supports.clamps.empty();
}

void read_supports(Table& t, RveScene& scene) {
  const auto clamps = t.tables("clamp"), loads = t.tables("load");
  if (!clamps.empty() && !open_and_free(scene))
    clamps.front().fail("", "clamps are for open samples: leave out [boundary] and [[wall]], or use boundary.bonded");
  if (!loads.empty() && scene.recipe.periodic()) loads.front().fail("", "a periodic cell has no ends");
  for (const auto& c : clamps) read_clamp(c, scene);
  for (const auto& l : loads) read_load(l, scene);
}

void read_glue(Table& t, RveScene& scene) {
  const std::string how = t.choice_or("bonded", "no", {"no", "normal", "full"});
  if (how == "no") return;
  if (!holds_on(scene)) t.fail("bonded", "needs packing.kind = \"voronoi\" and [material.NAME.bond]");
  scene.recipe.supports.glue = {how == "normal", t.place("bonded")};
}

void read_platens(Table& t, RveScene& scene) {
  if (!open_and_free(scene)) t.fail("kind", "\"platens\" makes its own two walls; leave out [boundary] and [[wall]]");
  dem::Platens platens;
  scene.test.axis = platens.axis = t.choice_or("axis", "z", {"x", "y", "z"})[0] - 'x';
  const double friction = t.number_or("friction", NAN, dimension::none, not_negative);
  platens.material = rigid_material(t, scene.model, friction);
  platens.by_speed = t.has("speed");
  if (platens.by_speed == t.has("strain_rate")) t.fail("", "needs either speed or strain_rate");
  platens.pace = platens.by_speed ? t.number("speed", dimension::speed, positive)
                                  : t.number("strain_rate", dimension::rate, positive);
  const double length = scene.recipe.box[platens.axis];
  if (platens.by_speed)
    refuse_fast(t, "speed", platens.pace, scene.model);
  else
    refuse_fast_rate(t, "strain_rate", platens.pace, length, scene.model);
  scene.test.final_strain = t.number("final_strain", dimension::none, {0, 0.95, true, true});
  scene.recipe.supports.press = platens;
}

void read_rollers(Table& t, RveScene& scene) {
  if (!open_and_free(scene)) t.fail("kind", "\"rollers\" makes its own; leave out [boundary] and [[wall]]");
  if (!scene.recipe.of_voronoi() || dem::is_round(scene.recipe))
    t.fail("kind", "\"rollers\" bends a box of Voronoi cells: packing.kind = \"voronoi\"");
  dem::Rollers r;
  scene.test.axis = r.axis = t.choice_or("axis", "z", {"x", "y", "z"})[0] - 'x';
  r.span = t.choice_or("span", "x", {"x", "y", "z"})[0] - 'x';
  if (r.span == r.axis) t.fail("span", "is across axis");
  const Vec3 box = dem::voronoi_box(scene.recipe);
  r.outer = t.number("outer", dimension::length, {0, box[r.span], true, true});
  r.inner = t.number_or("inner", 0, dimension::length, {0, r.outer, false, true});
  r.radius = t.number("radius", dimension::length, positive);
  for (const auto& [key, apart] : {std::pair{"outer", r.outer}, {"inner", r.inner}})
    if (apart > 0 && 2 * r.radius >= apart)
      t.fail("radius", fmt::format("{:g} m: two rollers that are {} = {:g} m apart would overlap; at most half of that",
                                   r.radius, key, apart));
  r.speed = t.number("speed", dimension::speed, positive);
  refuse_fast(t, "speed", r.speed, scene.model);
  r.material = rigid_material(t, scene.model, t.number_or("friction", 0, dimension::none, not_negative));
  r.place_of_outer = t.place("outer"), r.place_of_inner = t.place("inner");
  scene.test.duration = t.number("final_displacement", dimension::length, positive) / r.speed;
  scene.recipe.supports.press = r;
}

}  // namespace grus::app
