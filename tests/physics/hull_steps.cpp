// SPDX-License-Identifier: LGPL-3.0-or-later
// The critical step of hulls: how stiff their contacts are told to be, and that it is a bound.
#include "dem/motion/critical_step.hpp"
#include "tests/held_grains.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

TEST_CASE("loose hulls hardly below the critical step: by axis and by sharpness it is still a bound") {
  Team team(1);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Model model = loose(0);
    model.numerics.safety = 1;
    State s = pressed_cells(model, 60, 0.01, seed);
    prepare(model, s, team);
    run_for(model, s, 3000 * s.dt, team);
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.05);
    CHECK(stored_energy(model, s) < 1.05 * s.ledger.start);
  }
}

TEST_CASE("on a face, an edge and a corner a cube is as stiff as its force grows, by differences") {
  Team team(1);
  const Model model = loose(0);
  const Quat faces[] = {Quat::Identity(), Quat(Eigen::AngleAxisd(0.25 * pi, Vec3::UnitX())),
                        Quat::FromTwoVectors(Vec3::Ones(), Vec3::UnitZ())};
  for (const double d : {1e-3, 1e-2}) {
    double of_face = 0;
    for (int n = 2; n <= 4; ++n) {  // the potential's degree
      const double half = 0.5 * std::sqrt(n - 1.0);
      const auto pressed = [&](double overlap) {
        State s;
        add_body(s, unit_cube(), Vec3(0, 0, half - overlap), faces[n - 2]);
        add_floor(s);
        prepare(model, s, team);
        return s;
      };
      const auto force = [&](double overlap) { return pressed(overlap).contacts.touch[0].force.norm(); };
      const State s = pressed(d);
      const double stiffness = held_of(model, s).stiffness(0)(2, 2) * s.grains.mass[0], h = 1e-3 * d;
      CHECK(stiffness == Approx((force(d + h) - force(d - h)) / (2 * h)).epsilon(1e-5));
      CHECK(stiffness == Approx((n - 1) * force(d) / d).epsilon(1e-6));  // of degree n - 1
      if (n == 2) of_face = stiffness;
      if (n > 2) CHECK(stiffness < of_face);
    }
  }
}
