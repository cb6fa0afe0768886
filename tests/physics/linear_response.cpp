// SPDX-License-Identifier: LGPL-3.0-or-later
// The linear response of a contact network against closed forms and small perturbations.
#include "dem/rve/linear_response.hpp"

#include "dem/packing/packing.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/tangent.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;

TEST_CASE("linear response: simple cubic in closed form, a random sample as small perturbations have it, and where it ends") {
  {  // axial stiffness k / d; no coupling; shear: grains turn freely, half of k_t / d is left
    const double kn = 1e6, ratio = 0.8, R = 5e-4, d = 2 * R * (1 - 1e-5);
    const Model model = grus::dem::test::linear_model(kn, ratio, 2650, 1e3);
    State s;
    for (int x = 0; x < 3; ++x)
      for (int y = 0; y < 3; ++y)
        for (int z = 0; z < 3; ++z) grus::dem::test::add(s, PolyEllipsoid::sphere(R), d * Vec3(x, y, z), 2650);
    s.boundary.cell.vectors = 3 * d * Mat3::Identity();
    Team team(1);
    prepare(model, s, team);
    const auto r = linear_response(model, s, 0);
    REQUIRE(r);
    for (int k = 0; k < 3; ++k) {
      CHECK(r->tangent(k, k) == Approx(kn / d).epsilon(1e-6));
      CHECK(std::abs(r->tangent(k, (k + 1) % 3)) < 1e-6 * kn / d);
      CHECK(r->tangent(k + 3, k + 3) == Approx(0.5 * ratio * kn / d).epsilon(1e-4));
    }
    Vec6 stretch = Vec6::Zero();
    stretch[2] = 5e-6;  // overlaps are 1e-5: a third of the contacts lose half of their force
    CHECK_FALSE(r->holds(model, stretch, 0));
    stretch[2] = 5e-7;
    CHECK(r->holds(model, stretch, 0));
  }
  // Frictional spheres at an isotropic pressure, prepared with little friction: nothing slides at first.
  Model model = grus::dem::test::model_of(grus::dem::test::solid(600e6, 0.3, 2650, 0.1, 0.5));
  set_damping(model, 0.3);
  State s;
  const Packing p = random_packing(Vec3::Constant(0.036), {"uniform", 5e-3, 0, 4e-3, 6e-3}, 0.58, 0, true, 4);
  for (const auto& sphere : p.spheres) grus::dem::test::add(s, PolyEllipsoid::sphere(sphere.radius), sphere.position, 2650);
  s.boundary.cell.vectors = p.box.asDiagonal();
  Team team(2);
  prepare(model, s, team);
  QuasiStatic q;
  q.unbalanced_force = q.stress_change = 1e-6, q.max_hold = 400000;
  compress_isotropically(model, q, s, 1e5, team);
  for (auto& m : model.materials) m.friction = 10;
  make_pair_laws(model);
  const Response rest = hold(model, q, s, team);
  REQUIRE(rest.stable);
  const auto r = linear_response(model, s, 0.001);
  REQUIRE(r);
  std::uint64_t steps = 0;
  const Mat6 measured = perturbation_tangent(model, q, s, 1e-6, true, steps, team);
  // Perturbations of 1e-6 move stresses by 1e-4 of themselves, held to 1e-6; a few weak contacts open or close meanwhile.
  CHECK((measured - r->tangent).norm() < 0.03 * r->tangent.norm());
  // The affine bound is far stiffer: what relaxation is worth.
  CHECK(contact_stiffness_tangent(model, s)(0, 0) > 1.15 * r->tangent(0, 0));
}
