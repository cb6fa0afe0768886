// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/stage_scene.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scene/engine_scene.hpp"
#include "apps/scene/packing_scene.hpp"
#include "apps/scene/speeds.hpp"
#include "apps/scene/wall_scene.hpp"
#include "dem/rve/implicit_stepper.hpp"

namespace grus::app {
namespace {

using dem::Lateral;
using dem::Stage;
using dem::StageKind;
using dem::Swing;

constexpr double most_rows = 1e6;
constexpr Range strains{0, 0.95, false, true}, shears{0, 1000};

const std::vector<std::string> stage_kinds{"deposit", "compress", "hold",   "shear",
                                           "unload",  "reload",   "cyclic", "relax"};

template <class T>
T word_of(const std::string& word, const std::vector<std::string>& words) {
  return static_cast<T>(std::find(words.begin(), words.end(), word) - words.begin());
}

bool stands(const Stage& s) { return s.kind == StageKind::deposit || s.kind == StageKind::relax; }

void needs_bounds(const Table& t, const Stage& s, const RveScene& scene) {
  const dem::Recipe& r = scene.recipe;
  const std::string& kind = stage_kinds[static_cast<std::size_t>(s.kind)];
  if (s.kind == StageKind::deposit && (r.periodic() || (r.bounds == dem::Bounds::open && r.walls.empty())))
    t.fail("kind", "\"deposit\" needs walls to fall on");
  if (!stands(s) && r.bounds == dem::Bounds::open)
    t.fail("kind", fmt::format("\"{}\" needs boundary.kind = \"walls\", \"cylinder\" or \"periodic\"", kind));
  if (s.plane && !r.periodic()) t.fail("plane", "needs boundary.kind = \"periodic\"");
  const bool stays = r.in_cylinder() || r.bounds == dem::Bounds::periodic_xy;
  if (stays && !stands(s) && (s.axis != 2 || s.all || s.lateral != Lateral::fixed))
    t.fail("kind", "of a cylinder or \"periodic-xy\", whose sides stay, the axis is \"z\" and lateral is \"fixed\"");
}

void read_plane(Table& t, Stage& s) {
  const std::string plane = t.choice("plane", {"xy", "xz", "yx", "yz", "zx", "zy"});
  s.plane = {plane[0] - 'x', plane[1] - 'x'};
  s.axis = (*s.plane)[1];
  if (t.has("axis")) t.fail("axis", "is not with plane, whose second letter is the direction across");
}

void read_axis(Table& t, Stage& s) {
  const bool may_all = s.kind == StageKind::compress || s.kind == StageKind::hold;
  std::vector<std::string> words{"x", "y", "z"};
  if (may_all) words.emplace_back("all");
  const std::string axis = t.choice_or("axis", s.kind == StageKind::hold ? "all" : "z", words);
  s.all = axis == "all";
  if (!s.all) s.axis = axis[0] - 'x';
}

void read_lateral(Table& t, Stage& s, const dem::Model& model) {
  const std::vector<std::string> words{"fixed", "held", "volume"};
  const bool held = s.kind == StageKind::shear || s.kind == StageKind::cyclic || t.has("lateral_stress");
  s.lateral = word_of<Lateral>(t.choice_or("lateral", held ? "held" : "fixed", words), words);
  if (s.lateral == Lateral::volume && (s.stress_rate || s.kind == StageKind::hold))
    t.fail("lateral", "\"volume\" needs an axis that follows a rate of strain");
  if (!t.has("lateral_stress")) return;
  s.lateral_stress = t.number("lateral_stress", dimension::pressure, positive);
  refuse_high_pressure(t, "lateral_stress", *s.lateral_stress, model);
  if (s.lateral != Lateral::held) t.fail("lateral_stress", "is for lateral = \"held\"");
}

/// The rate of the axis, or of its stress.
void read_rate(Table& t, Stage& s) {
  if (s.kind == StageKind::hold) {
    s.strain_rate = t.number_or("strain_rate", 0, dimension::rate, not_negative);
    return;
  }
  s.strain_rate = t.number("strain_rate", dimension::rate, s.kind == StageKind::shear ? any : positive);
  if (s.strain_rate == 0) t.fail("strain_rate", "must not be 0");
  if (!t.has("stress_rate")) return;
  if (!s.one_way() || s.all) t.fail("stress_rate", "is of one axis that is compressed, unloaded or reloaded");
  s.stress_rate = t.number("stress_rate", dimension::stress_rate, positive);
}

void read_cycles(Table& t, Stage& s) {
  int found = 0;
  const auto swing = [&](const char* key, Swing by, const Dimension& dimension, const Range& range) {
    if (!t.has(key)) return;
    if (++found > 1) t.fail(key, "is the second amplitude: give one");
    s.swing = by, s.amplitude = t.number(key, dimension, range);
  };
  swing("strain_amplitude", Swing::strain, dimension::none, {0, 0.5, true, true});
  swing("stress_amplitude", Swing::stress, dimension::pressure, positive);
  swing("deviator_amplitude", Swing::deviator, dimension::pressure, positive);
  if (found == 0) t.fail("", "needs strain_amplitude, stress_amplitude or deviator_amplitude");
  s.cycles = static_cast<std::uint64_t>(t.integer("cycles", 1, 1000000));
}

/// `solved`: by steps that solve their contacts.
void read_ends(Table& t, Stage& s, bool solved) {
  auto u = t.table_if("until");
  if (!u) return;
  const auto read = [&](const char* key, std::optional<double>& end, const Dimension& dimension, const Range& range) {
    if (u->has(key)) end = u->number(key, dimension, range);
  };
  if (!stands(s) && s.kind != StageKind::cyclic && s.kind != StageKind::hold) {
    read("stress", s.until.stress, dimension::pressure, s.all ? positive : any);
    if (!s.plane && !s.all) read("deviator", s.until.deviator, dimension::pressure, any);
  }
  if (!stands(s)) read("strain", s.until.strain, dimension::none, s.plane ? shears : strains);
  read("void_ratio", s.until.void_ratio, dimension::none, positive);
  read("time", s.until.time, dimension::time, not_negative);
  read("unbalanced_force", s.until.unbalanced_force, dimension::none, {0, 1, true});
  if (solved && s.until.unbalanced_force && *s.until.unbalanced_force < dem::least_unbalanced)
    u->fail("unbalanced_force", fmt::format("must be at least {:g} with numerics.engine = \"implicit\", which finds "
                                            "forces no better",
                                            dem::least_unbalanced));
  u->finish();
  if (s.until.stress && s.until.deviator) u->fail("deviator", "cannot be beside stress: give one");
}

bool ends(const Stage& s) {
  const dem::StageEnds& u = s.until;
  return u.stress || u.deviator || u.strain || u.void_ratio || u.time || u.unbalanced_force || s.to_turn;
}

/// How far a stage may go for its end, and how long.
void read_bounds(Table& t, Stage& s) {
  if (!stands(s)) {
    s.max_strain = t.number_or("max_strain", s.plane ? 10 : 0.6, dimension::none, s.plane ? shears : strains);
    if (s.until.strain && *s.until.strain > s.max_strain)
      t.fail("max_strain", fmt::format("{:g} is less than until.strain, {:g}", s.max_strain, *s.until.strain));
  }
  if (t.has("max_time")) s.max_time = t.number("max_time", dimension::time, positive);
  if ((stands(s) || s.kind == StageKind::hold) && s.max_time == 0 && !s.until.time)
    t.fail("", "needs until.time, or max_time beside another end: nothing else bounds how long it takes");
}

void read_grains(Table& t, Stage& s, const RveScene& scene) {
  if (t.has("friction")) s.friction = t.number("friction", dimension::none, not_negative);
  for (const dem::Material& m : scene.model.materials)
    if (s.friction && *s.friction > 0 && m.rolling_friction > 0 && m.friction == 0)
      t.fail("friction", fmt::format("material.{} has rolling_friction, which needs a friction of its own", m.name));
  if (t.has("damping")) s.damping = t.number("damping", dimension::none, {0, 1, false, true});
  if (s.damping.value_or(0) > 0 && scene.model.stepper->long_steps)
    t.fail("damping", "must be 0 with numerics.engine = \"implicit\", whose steps need none");
  if (t.has("gravity")) s.gravity = vector3(t.numbers("gravity", 3, dimension::acceleration));
  if (s.gravity && !s.gravity->isZero() && scene.model.numerics.scales_inertia())
    t.fail("gravity", "cannot be with numerics.inertia: what resists motion would weigh, too");
}

Stage read_stage(Table& t, const RveScene& scene) {
  Stage s;
  s.kind = word_of<StageKind>(t.choice("kind", stage_kinds), stage_kinds);
  s.name = t.text_or("name", stage_kinds[static_cast<std::size_t>(s.kind)]);
  s.place = t.place("kind");
  read_grains(t, s, scene);
  if (!stands(s)) {
    if (s.kind == StageKind::shear && t.has("plane"))
      read_plane(t, s);
    else
      read_axis(t, s);
    read_rate(t, s);
    if (!s.all && !s.plane) read_lateral(t, s, scene.model);
  }
  if (s.kind == StageKind::cyclic) read_cycles(t, s);
  needs_bounds(t, s, scene);
  const dem::Vec3& box = scene.recipe.box;
  if (!stands(s)) refuse_fast_rate(t, "strain_rate", s.strain_rate, s.all ? box.maxCoeff() : box[s.axis], scene.model);
  check_rigid(t, scene.model, stands(s));
  read_ends(t, s, scene.model.stepper->long_steps);
  if (s.until.void_ratio && scene.recipe.bounds == dem::Bounds::open)
    t.fail("until", "a void ratio is of a box, a cylinder or a cell");
  s.rows = static_cast<std::uint64_t>(t.integer_or("rows", 25, 1, 1000000));
  return s;
}

/// What a stage asks of those before it.
void check_order(const Table& t, Stage& s, const std::vector<Stage>& before) {
  const bool leaned = std::any_of(before.begin(), before.end(), [](const Stage& b) { return b.plane.has_value(); });
  if (leaned && !s.plane && !stands(s))
    t.fail("kind", "a cell that has been sheared in a plane leans: its axes cannot be loaded alone");
  if (s.kind == StageKind::deposit && !s.gravity &&
      std::none_of(before.begin(), before.end(), [](const Stage& b) { return b.gravity.has_value(); }))
    t.fail("", "needs gravity");
  const bool unloaded = std::any_of(before.begin(), before.end(),
                                    [&](const Stage& b) { return b.kind == StageKind::unload && b.axis == s.axis; });
  s.to_turn = s.kind == StageKind::reload && unloaded && !ends(s);
  if (!ends(s) && s.kind != StageKind::cyclic)
    t.fail("until", s.kind == StageKind::reload ? "is missing, and no stage before unloads this axis"
                                                : "is missing: when does it end?");
  if (s.all && s.kind == StageKind::compress && !s.until.stress)
    t.fail("until", "needs a stress, which all axes are brought to");
  if (s.stress_rate && !s.until.stress && !s.to_turn) t.fail("until", "needs a stress, which stress_rate goes to");
}

}  // namespace

double rows_of(const dem::Programme& test) {
  double rows = 1;
  for (const Stage& s : test.stages) rows += static_cast<double>(s.rows) * static_cast<double>(s.legs());
  return rows;
}

std::optional<double> known_duration(const dem::Programme& test) {
  double sum = 0;
  for (const Stage& s : test.stages) {
    std::optional<double> time = s.until.time;
    const auto by = [&](double t) { time = std::min(time.value_or(t), t); };
    if (s.by_strain() && s.until.strain) by(*s.until.strain / std::abs(s.strain_rate));
    if (s.kind == StageKind::cyclic && s.swing == Swing::strain)
      by(4 * s.amplitude * static_cast<double>(s.cycles) / s.strain_rate);
    if (!time) return {};
    sum += *time;
  }
  return sum;
}

void read_stages(Table& t, RveScene& scene) {
  if (t.has("loading")) t.fail("loading", "cannot be with [[stage]]: a test has one or the other");
  refuse_own_motion(t, "stage", scene);
  dem::Programme& test = scene.test;
  test.kind = dem::TestKind::staged;
  for (Table& s : t.tables("stage")) {
    Stage stage = read_stage(s, scene);
    check_order(s, stage, test.stages);
    read_bounds(s, stage);
    s.finish();
    test.stages.push_back(std::move(stage));
    if (rows_of(test) > most_rows) s.fail("rows", "more than a million rows in all; ask for fewer");
  }
  test.duration = known_duration(test).value_or(1);
}

}  // namespace grus::app
