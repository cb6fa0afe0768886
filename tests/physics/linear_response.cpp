// SPDX-License-Identifier: LGPL-3.0-or-later
// The linear response of a contact network against closed forms and small perturbations.
#include "dem/rve/linear_response.hpp"

#include "dem/packing/packing.hpp"
#include "dem/rve/block_cholesky.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/tangent.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;

TEST_CASE(
    "linear response: simple cubic in closed form, a random sample as small perturbations have it, and where it ends") {
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
  for (const double rolling : {0.0, 0.1}) {
    Model model = grus::dem::test::model_of(grus::dem::test::solid(600e6, 0.3, 2650, 0.1, 0.5));
    model.materials[0].rolling_friction = rolling;
    make_pair_laws(model);
    set_damping(model, 0.3);
    State s;
    const Packing p = random_packing(Vec3::Constant(0.036), {"uniform", 5e-3, 0, 4e-3, 6e-3}, 0.58, 0, true, 4);
    for (const auto& sphere : p.spheres)
      grus::dem::test::add(s, PolyEllipsoid::sphere(sphere.radius), sphere.position, 2650);
    s.boundary.cell.vectors = p.box.asDiagonal();
    Team team(2);
    prepare(model, s, team);
    QuasiStatic q;
    q.unbalanced_force = q.stress_change = 1e-6, q.max_hold = 400000;
    compress_isotropically(model, q, s, 1e5, team);
    model.materials[0].friction = 10, model.materials[0].rolling_friction = 100 * rolling;
    make_pair_laws(model);
    const Response rest = hold(model, q, s, team);
    REQUIRE(rest.stable);
    const auto r = linear_response(model, s, 0.001);
    REQUIRE(r);
    std::uint64_t steps = 0;
    const Mat6 measured = perturbation_tangent(model, q, s, 1e-6, true, steps, team);
    // Perturbations of 1e-6 move stresses by 1e-4 of themselves, held to 1e-6; a few weak contacts open or close
    // meanwhile.
    CHECK((measured - r->tangent).norm() < 0.03 * r->tangent.norm());
    // The affine bound is far stiffer: what relaxation is worth.
    CHECK(contact_stiffness_tangent(model, s)(0, 0) > 1.15 * r->tangent(0, 0));
    // Grains that cannot roll freely shear less.
    if (rolling > 0) {
      Model free = model;
      for (PairLaw& law : free.pairs) law.friction[roll_spring] = 0;
      LinearResponse near = *r;
      Vec6 push = Vec6::Zero();
      push[3] = 1e-8;
      CHECK(near.holds(model, push, 0.001));
      for (auto& roll : near.couples[roll_spring]) roll.friction = 1e-9;
      CHECK_FALSE(near.holds(model, push, 0.001));
      const auto shear = [](const LinearResponse& of) { return of.tangent.bottomRightCorner<3, 3>().trace(); };
      CHECK(shear(*r) > 1.02 * shear(*linear_response(free, s, 0.001)));
    }
    CHECK(r->couples[roll_spring].empty() == (rolling == 0));
  }
}

TEST_CASE(
    "the network's solver against a dense one: rings, a hub, a row of its own, links told twice and both ways round") {
  const int n = 40;
  std::vector<std::pair<int, int>> links;
  for (int i = 0; i < 30; ++i) links.emplace_back(i, (i + 1) % 30), links.emplace_back((7 * i + 3) % 30, i);
  for (int i = 30; i < n - 1; ++i) links.emplace_back(i, 5);  // the hub is 5; 39 has no link
  std::erase_if(links, [](const auto& l) { return l.first == l.second; });
  links.push_back(links.front());
  BlockCholesky sparse(n, links);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  auto add = [&](int i, int j, const Mat6& block) {
    sparse.add(i, j, block);
    dense.block<6, 6>(6 * i, 6 * j) += block;
    if (i != j) dense.block<6, 6>(6 * j, 6 * i) += block.transpose();
  };
  std::srand(1);  // Eigen's Random
  for (std::size_t k = 0; k < links.size(); ++k) {
    const auto [i, j] = links[k];
    const Mat6 off = Mat6::Random();
    k % 2 ? add(i, j, off) : add(j, i, off);
    const double held =
        1.1 * Eigen::JacobiSVD<Mat6>(off).singularValues()[0];  // block diagonal dominance: positive definite
    add(i, i, held * Mat6::Identity()), add(j, j, held * Mat6::Identity());
  }
  add(n - 1, n - 1, 2 * Mat6::Identity());
  const Eigen::MatrixXd load = Eigen::MatrixXd::Random(6 * n, 6);
  Eigen::MatrixXd x = load;
  REQUIRE(sparse.factorise());
  sparse.solve(x);
  CHECK((dense * x - load).norm() <
        1e-12 * load.norm());  // no more than round-off times a condition number of some 100
  BlockCholesky nothing(2, {});
  CHECK_FALSE(nothing.factorise());  // a block of zeros cannot be inverted
}
