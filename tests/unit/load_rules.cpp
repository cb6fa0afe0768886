// SPDX-License-Identifier: LGPL-3.0-or-later
// What decides that a grain breaks, and where: criteria asked of loads that are told by hand; planes, strengths and
// shapes in closed form.
#include <algorithm>

#include "dem/fracture/break_plane.hpp"
#include "dem/fracture/criteria.hpp"
#include "dem/fracture/shape_transition.hpp"
#include "dem/motion/critical_step.hpp"
#include "dem/rve/crushing.hpp"
#include "dem/rve/measure.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

struct Told {
  double force, radius;
  Vec3 arm;
};

/// A grain whose load is what its contacts are told to be.
struct ToldGrain {
  std::vector<Told> contacts;
  Mat3 stresses = Mat3::Zero();
  double nu = 0.2, size = 2;

  Mat3 stress() const { return stresses; }
  double poissons_ratio() const { return nu; }
  double radius() const { return size; }
  Vec3 arm(Index at) const { return contacts[at].arm; }
  template <class F>
  void each_contact(F&& f) const {
    for (std::size_t k = 0; k < contacts.size(); ++k) f(contacts[k].force, contacts[k].radius, static_cast<Index>(k));
  }
};
static_assert(GrainUnderLoad<ToldGrain>);

/// Force whose tension under a contact of unit radius is this (Pa): nu = 0.2 gives 0.3 F / pi.
double force_for(double tension) { return tension * pi / 0.3; }

}  // namespace

TEST_CASE("tension under contacts: as many as asked for reach it, and not all in line") {
  ToldGrain g;
  const Vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  g.contacts = {{force_for(5), 1, x}, {force_for(9), 1, y}, {force_for(3), 1, z}, {force_for(7), 1, -x}};
  CHECK(ContactTension::tension(force_for(5), 1, 0.2) == Approx(5).epsilon(1e-12));
  CHECK(ContactTension::tension(force_for(5), 2, 0.2) == Approx(1.25).epsilon(1e-12));
  for (const auto& [count, reached] : {std::pair{1, 9.0}, {2, 7.0}, {3, 5.0}, {4, 3.0}})
    CHECK(ContactTension{10, count}.utilisation(g, 2) == Approx(reached / 20).epsilon(1e-12));
  CHECK(ContactTension{10, 5}.utilisation(g, 1) == 0);
  // The plane of the three largest: y, -x, x.
  const auto plane = contact_plane(g, 4, 3);
  REQUIRE(plane);
  CHECK(std::abs(plane->dot(z)) == Approx(1).epsilon(1e-12));
  CHECK(std::abs(contact_plane(g, 2.9, 3)->dot(z)) == Approx(1).epsilon(1e-12));  // z is the fourth
  CHECK(!contact_plane(g, 5.001, 3));
  CHECK(contact_plane(g, 2.9, 4));
  CHECK(!contact_plane(g, 4, 4));
  CHECK(!contact_plane(g, 8, 1));  // three at least, whatever is asked
  // In line the next one is taken; all in line break nothing.
  g.contacts = {{force_for(9), 1, x}, {force_for(8), 1, 2 * x}, {force_for(7), 1, 3 * x}, {force_for(6), 1, y}};
  REQUIRE(contact_plane(g, 5, 3));
  CHECK(std::abs(contact_plane(g, 5, 3)->dot(z)) == Approx(1).epsilon(1e-12));
  CHECK(ContactTension{6, 3}.utilisation(g, 1) == Approx(7.0 / 6));
  g.contacts.pop_back();
  CHECK(!contact_plane(g, 5, 3));
  CHECK(ContactTension{7, 3}.utilisation(g, 1) == 0);
  CHECK(ContactTension{7.1, 3}.utilisation(g, 1) == Approx(7 / 7.1));  // near to failing it is still told
}

TEST_CASE("the largest contact tells the direction, the force between platens and the stress under it") {
  ToldGrain g;
  CHECK(load_direction(g).isZero(0));
  CHECK(!largest_contact(g).at);
  g.contacts = {{3, 0.5, Vec3(0, 2, 0)}, {8, 2, Vec3(0, 0, -4)}, {8, 1, Vec3(1, 0, 0)}};
  CHECK(largest_contact(g).at == 1u);  // the first of equals
  CHECK(largest_contact(g).force == 8);
  CHECK((load_direction(g) - Vec3(0, 0, -1)).norm() < 1e-15);
  CHECK(PlatenForce{0.25}.utilisation(g, 2) == Approx(8 / (16 * 0.25 * 2)));
  CHECK(ContactStrength{2, {}}.utilisation(g, 2) == Approx(3 / (pi * 0.25) / 4));   // by pressure, not by force
  CHECK(ContactStrength{2, pi / 6}.utilisation(g, 2) == Approx(8 / (pi * 1) / 4));  // R sin 30 = 1
  // Hoek and Brown: s1 = s3 + s sqrt(m s3 / s + 1), pressed positive.
  const HoekBrown rock{10, 6};
  const double s3 = 4, s1 = s3 + 20 * std::sqrt(6 * s3 / 20 + 1);
  g.stresses = Vec3(-s3, -s1, -5).asDiagonal();
  CHECK(rock.utilisation(g, 2) == Approx(1).epsilon(1e-12));
  g.stresses = Vec3(20 / 6.0, 0, 0).asDiagonal();  // the apex
  CHECK(rock.utilisation(g, 2) == Approx(1).epsilon(1e-12));
  g.stresses *= 3;
  CHECK(rock.utilisation(g, 2) == Approx(3).epsilon(1e-12));
}

TEST_CASE("criteria are asked in their order until one fails; the largest utilisation is told") {
  ToldGrain g;
  g.contacts = {{8, 1, Vec3(0, 0, 1)}};
  const PlatenForce tough{5}, weak{0.5}, weaker{0.25};  // 0.1, 1, 2
  const auto asked = [&](std::vector<Criterion> all) {
    const Verdict v = judge(all, g, 1);
    return std::pair{v.utilisation, v.by};
  };
  CHECK(asked({tough}) == std::pair{0.1, std::size_t{0}});
  CHECK(asked({tough, weak, weaker}) == std::pair{1.0, std::size_t{1}});
  CHECK(asked({weaker, tough}) == std::pair{2.0, std::size_t{0}});
  CHECK(asked({PlatenForce{1}, tough}).first == 0.5);
  CHECK(asked({}).first == 0);
}

TEST_CASE("a grain is turned the shortest way until its axis stands on the plane, either way round") {
  for (std::uint64_t k = 0; k < 8; ++k)
    for (const int axis : {0, 1, 2}) {
      const Quat q(Eigen::AngleAxisd(0.4 * static_cast<double>(k), Vec3(1, 2, 3).normalized()));
      const Vec3 normal = Vec3(std::sin(1.0 * static_cast<double>(k)), 0.3, -0.5).normalized(),
                 from = q * Vec3::Unit(axis);
      const Quat turned = turned_to_plane(q, axis, normal);
      CHECK(std::abs((turned * Vec3::Unit(axis)).dot(normal)) == Approx(1).epsilon(1e-12));
      CHECK(q.angularDistance(turned) == Approx(std::acos(std::abs(from.dot(normal)))).margin(1e-7));
    }
}

TEST_CASE("a strength is drawn by size, seed and number; without a law of fracture it is one") {
  Model model = model_of(solid(60e9, 0.2, 2650));
  State s;
  add(s, PolyEllipsoid::sphere(2e-3), Vec3::Zero(), 2650), add(s, PolyEllipsoid::sphere(1e-3), Vec3::Ones(), 2650);
  s.grains.strength = {7, 7};
  draw_strength(model, s.grains, 0);
  CHECK((s.grains.strength == std::vector<double>{1, 7}));
  model.materials[0].fracture = FractureModel{};
  model.materials[0].fracture->strength_law = Weibull{3, 1e-3};
  model.seed = 5;
  for (std::size_t i = 0; i < 2; ++i) {
    draw_strength(model, s.grains, i);
    const double drawn = model.materials[0].fracture->strength_factor(i == 0 ? 2e-3 : 1e-3, 5, s.grains.id[i]);
    CHECK(s.grains.strength[i] == Approx(drawn).epsilon(1e-12));
  }
  const double same_draw = model.materials[0].fracture->strength_factor(1e-3, 5, s.grains.id[0]);
  CHECK(s.grains.strength[0] == Approx(same_draw / 8).epsilon(1e-12));  // twice as large, exponent 3
  CHECK(s.grains.strength[1] != Approx(same_draw).epsilon(1e-6));
}

TEST_CASE("a flat fragment's short side grows by its aim in the time told, the width stays, and then it is done") {
  PolyEllipsoid p;
  p.plus = Vec3(1, 3, 2), p.minus = Vec3(9, 1, 2);  // ratio 1 : 4 asked: aims 2, 0.8 and 0.8
  const ShapeTransition t{0.25, 10};
  const auto next = next_shape(p, t, 2);
  REQUIRE(next);
  CHECK((next->plus - Vec3(1.4, 3, 2)).norm() < 1e-12);
  CHECK((next->minus - Vec3(8.6, 1, 2)).norm() < 1e-12);
  const auto last = next_shape(p, t, 30);
  REQUIRE(last);
  CHECK((last->plus - Vec3(2, 3, 2)).norm() < 1e-12);
  CHECK((last->minus - Vec3(8, 1, 2)).norm() < 1e-12);
  CHECK(!next_shape(*last, t, 1));
  std::swap(p.plus, p.minus);
  CHECK((next_shape(p, t, 2)->minus - Vec3(1.4, 3, 2)).norm() < 1e-12);
}

TEST_CASE("the step of a spring with a dashpot, and eigenvalues with their bound") {
  CHECK(with_dashpots(7, 0) == 7);
  for (const auto& [k, c] : {std::pair{1.0, 2.0}, {9.0, 0.1}, {0.0, 3.0}}) {
    const double dt = 2 / std::sqrt(with_dashpots(k, c));
    CHECK(k * dt * dt + 2 * c * dt == Approx(4).epsilon(1e-12));
  }
  Mat6 m = Mat6::Zero();
  for (int k = 0; k < 6; ++k) m(k, k) = k;
  CHECK(largest_eigenvalue(m) == Approx(5).epsilon(1e-12));
  CHECK(largest_eigenvalue_bound(m) >= 5);
  CHECK(largest_eigenvalue_bound(m) == Approx(std::pow(1 + 256.0 + 6561 + 65536 + 390625, 1.0 / 8)).epsilon(1e-9));
  CHECK(largest_eigenvalue_bound(Mat6::Identity()) == Approx(std::pow(6, 1.0 / 8)).epsilon(1e-9));
}

TEST_CASE("sizes of grains and shifts of a strain are what they are called") {
  State s;
  CHECK(mean_diameter(s.grains) == 0);
  for (const double r : {1.0, 2.0, 6.0}) add(s, PolyEllipsoid::sphere(r), Vec3::Zero(), 2650);
  CHECK(mean_diameter(s.grains) == Approx(6).epsilon(1e-12));
  const Vec3 l(2, -3, 5);
  Eigen::Matrix<double, 6, 1> strain;
  strain << 0.1, 0.2, 0.3, 0.04, 0.05, 0.06;
  Mat3 e = Mat3::Zero();
  for (int k = 0; k < 6; ++k)
    e(voigt_row[k], voigt_col[k]) = e(voigt_col[k], voigt_row[k]) = (k < 3 ? 1 : 0.5) * strain[k];
  CHECK((displacement_of_strain(l) * strain - e * l).norm() < 1e-15);
}
