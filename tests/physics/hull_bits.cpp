// SPDX-License-Identifier: LGPL-3.0-or-later
// Runs of hulls: what is kept of their overlaps from step to step decides no bit.
#include "dem/io/archive.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/rve/step.hpp"
#include "dem/sample/prepare.hpp"
#include "dem/shape/separation.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

State packed(Model& model, Team& team) {
  model = hull_model(0.5, 1e9, 0.3);
  Recipe recipe;
  RandomPacking grains;
  grains.radius = {.kind = "uniform", .mean = 0.5, .min = 0.4, .max = 0.6};
  grains.solid_fraction = 0.14, grains.hulls = RandomHulls{.rounds = 3, .aspect = Vec3(1, 0.8, 0.6)};
  recipe.bounds = Bounds::periodic, recipe.box = Vec3::Constant(6), recipe.grains = grains;
  recipe.preparation = Preparation{.pressure = 1e6, .friction = 0.2};
  return make_ready(model, recipe, team);
}

}  // namespace

TEST_CASE("a run goes on with the same bits from its bytes, without guesses, and on two threads") {
  Model model;
  Team one(1), two(2);
  const State start = packed(model, one);
  Loading loading;
  loading.driven = true;
  loading.axes[2].strain_rate = -1e-3 / start.dt / 200;
  const auto run = [&](int pieces, Team& team, auto&& between) {
    State s = start;
    Loading l = loading;
    begin_loading(model, s, l);
    for (int k = 0; k < pieces; ++k) run_steps(model, s, 240 / static_cast<std::uint64_t>(pieces), team), between(s);
    return hash(s);
  };
  const std::uint64_t whole = run(1, one, [](State&) {});
  CHECK(run(1, two, [](State&) {}) == whole);
  CHECK(run(24, one, [](State& s) {
          for (auto& row : s.contacts.guesses.row) row.guess.octets = 0;
        }) == run(24, one, [](State&) {}));
  CHECK(run(3, one, [](State& s) { s = state_of(bytes_of(s)); }) == run(3, one, [](State&) {}));
}

TEST_CASE("of hulls that edges alone part the direction that parts them is kept with the pair") {
  const Model model = hull_model();
  const Quat upright = rotation_by(pi / 4 * Vec3::UnitX()), crossed = rotation_by(pi / 3 * Vec3::UnitZ()) * upright;
  State s;
  add_body(s, unit_cube(), Vec3::Zero(), upright);
  add_body(s, unit_cube(), Vec3(0.2, 0.3, std::sqrt(2.0) + 0.01), crossed);
  Team team(1);
  Model free = model;
  free.numerics.time_step = 1e-6;
  prepare(free, s, team);
  REQUIRE(s.contacts.size() == 1);
  const auto parted = [&] {
    const HullView a = (*s.grains.hulls)[s.grains.hull[0]], b = (*s.grains.hulls)[s.grains.hull[1]];
    const Mat3 &axes_a = s.grains.frame[0].axes, &axes_b = s.grains.frame[1].axes, back = axes_a.transpose();
    const Vec3 shift = s.grains.motion[1].position - s.grains.motion[0].position;
    return separation_along(a, b, back * axes_b, back * shift, back * s.contacts.touch[0].normal);
  };
  CHECK(parted() == Approx(0.01).epsilon(1e-9));  // the list has found it
  s.contacts.touch[0].normal = Vec3(0, 1, 1).normalized();
  CHECK(parted() < 0);  // a face's normal does not part them
  run_steps(free, s, 1, team);
  CHECK(parted() == Approx(0.01).epsilon(1e-6));
  CHECK(!s.contacts.contact.touching(0));
}
