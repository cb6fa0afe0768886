// SPDX-License-Identifier: LGPL-3.0-or-later
// What contacts, lists and gauges decide, each by itself: laws asked by number, bins of pairs, ways of walls and cells,
// levers of hulls, dead loads.
#include "dem/contact/hull_pairs.hpp"
#include "dem/contact/listing.hpp"
#include "dem/sample/gauge.hpp"
#include "dem/sample/recipe.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double E = 60e9, nu = 0.2;
const Solid quartz{E, nu}, rigid{INFINITY, 0};

PairLaw pair_of(const ContactLaw& law, const LawConstants& of, const Solid& other = quartz) {
  PairLaw p;
  mix(law, quartz, of, other, of, p);
  return p;
}

}  // namespace

TEST_CASE("the force at an overlap, the reach of an attraction, and the kinds of the laws") {
  const double R = 1e-3, d = 1e-6, W = 0.5, star = E / (2 * (1 - nu * nu));
  CHECK(force_at(HertzMindlin{}, pair_of(HertzMindlin{}, {}), R, d) ==
        Approx(4.0 / 3 * star * std::sqrt(R) * std::pow(d, 1.5)).epsilon(1e-12));
  CHECK(force_at(HertzMindlin{}, pair_of(HertzMindlin{}, {}, rigid), R, d) ==
        Approx(8.0 / 3 * star * std::sqrt(R) * std::pow(d, 1.5)).epsilon(1e-12));
  const LinearSpring::Of by_number{.stiffness = 3e5}, by_modulus{.modulus = 2e8};
  CHECK(force_at(LinearSpring{}, pair_of(LinearSpring{}, by_number), R, d) == Approx(0.3).epsilon(1e-12));
  CHECK(force_at(LinearSpring{}, pair_of(LinearSpring{}, by_modulus), R, d) == Approx(4 * 2e8 * R * d).epsilon(1e-12));
  CHECK(std::isinf(force_at(Foundation{}, pair_of(Foundation{}, Foundation::Of{.modulus = 1e9}), R, d)));
  // JKR: overlap -3 a_c^2 / R with a_c^3 = pi W R^2 / (8 E*); the largest of the pairs counts.
  const PairLaw none = pair_of(Jkr{}, Jkr::Of{0}), some = pair_of(Jkr{}, Jkr::Of{W});
  const double reach = 3 * std::pow(pi * W * R * R / (8 * star), 2.0 / 3) / R;
  CHECK(reach_of(Jkr{}, std::vector{none, some, none}, R) == Approx(reach).epsilon(1e-12));
  CHECK(reach_of(Jkr{}, std::vector{none}, R) == 0);
  CHECK(reach_of(HertzMindlin{}, std::vector{some}, R) == 0);
  CHECK((attracts(Jkr{}) && !attracts(HertzMindlin{}) && !attracts(LinearSpring{}) && !attracts(Foundation{})));
  CHECK((of_hulls(Foundation{}) && !of_hulls(HertzMindlin{}) && !of_hulls(LinearSpring{}) && !of_hulls(Jkr{})));
  CHECK((stiffens(HertzMindlin{}) && stiffens(Jkr{}) && stiffens(Foundation{}) && !stiffens(LinearSpring{})));
}

TEST_CASE("stiffness between grains of a radius, and energy of a volume under unit strain") {
  const LinearSpring::Of by_number{.stiffness = 3e5}, by_modulus{.modulus = 2e8};
  for (const ContactLaw& law : {ContactLaw{HertzMindlin{}}, ContactLaw{Foundation{}}, ContactLaw{Jkr{}}}) {
    CHECK(stiffness_between(law, quartz, {}, 0.01) == Approx(0.02 * E));
    CHECK(energy_of_strain(law, quartz, {}, 8e-6) == Approx(8e-6 * E));
  }
  CHECK(stiffness_between(LinearSpring{}, quartz, by_number, 0.01) == 3e5);
  CHECK(stiffness_between(LinearSpring{}, quartz, by_modulus, 0.01) == Approx(2 * 2e8 * 0.01));  // 4 K over half of R
  CHECK(energy_of_strain(LinearSpring{}, quartz, by_number, 8e-6) == Approx(3e5 * 4e-4));
  CHECK(energy_of_strain(LinearSpring{}, quartz, by_modulus, 8e-6) == Approx(8e8 * 8e-6));
  LawConstants of = Jkr::Of{0.5};
  scale(Jkr{}, of, 3);
  CHECK(std::get<Jkr::Of>(of).work == 1.5);
  of = by_number;
  scale(LinearSpring{}, of, 3), scale(Jkr{}, of, 3);
  CHECK(std::get<LinearSpring::Of>(of).stiffness == 3e5);
}

TEST_CASE("pairs of shapes meet in the bin of their kinds") {
  using enum ShapeKind;
  CHECK(pair_bin(sphere, sphere) == sphere_sphere);
  CHECK((pair_bin(sphere, polyellipsoid) == general && pair_bin(polyellipsoid, sphere) == general));
  CHECK((pair_bin(polyellipsoid, polyellipsoid) == general && pair_bin(hull, hull) == hull_hull));
  CHECK((wall_bin(sphere, {}) == sphere_wall && wall_bin(polyellipsoid, {}) == polyellipsoid_wall &&
         wall_bin(hull, {}) == hull_wall));
}

TEST_CASE("pairs are near by their bounding spheres, through the cell's edges; cells and walls take gaps away") {
  State s;
  add(s, PolyEllipsoid::sphere(1), Vec3::Zero(), 1), add(s, PolyEllipsoid::sphere(2), Vec3(0, 0, 3.4), 1);
  Cell cell;
  cell.vectors << 10, 0, 2, 0, 10, 0, 0, 0, 10;
  CHECK(close(s.grains, cell, {0, 1, {}}, 0.41));
  CHECK(!close(s.grains, cell, {0, 1, {}}, 0.39));
  s.grains.motion[1].position = Vec3(2, 0, 13.4) - 2 * Vec3(2, 0, 10);
  CHECK(close(s.grains, cell, {0, 1, {0, 0, 1}}, 0.41));
  CHECK(!close(s.grains, cell, {0, 1, {0, 0, 1}}, 0.39));
  CHECK(!close(s.grains, cell, {0, 1, {}}, 0.41));
  const Mat3 before = cell.vectors;
  cell.vectors = (Mat3::Identity() + Mat3(Vec3(0.03, 0, -0.04).asDiagonal())) * before;
  CHECK(affine_loss(cell, before, 7) == Approx(0.35).epsilon(1e-12));
  CHECK(affine_loss({}, before, 7) == 0);
  NeighbourReference reference;
  Boundary boundary;
  boundary.walls.resize(3);
  reference.wall_point.assign(3, Vec3(1, 1, 1));
  for (Wall& w : boundary.walls) w.point = Vec3(1, 1, 1);
  boundary.walls[0].shape = PlaneWall{Vec3::UnitZ()}, boundary.walls[0].point += Vec3(5, 5, -0.3);
  boundary.walls[1].shape = CylinderWall{Vec3::UnitZ(), 4}, boundary.walls[1].point += Vec3(0, 0, 9);
  CHECK(wall_travel(boundary, reference) == Approx(0.3).epsilon(1e-12));
  boundary.walls[2].shape = RollerWall{Vec3::UnitZ(), 1, 0}, boundary.walls[2].point += Vec3(0.3, 0.4, 0);
  CHECK(wall_travel(boundary, reference) == Approx(0.5).epsilon(1e-12));
}

TEST_CASE("a blow on the rim of a flake meets a part of its mass; foundations are over the hulls' depths") {
  State s;
  const Vec3 half(1, 2, 0.1);
  add_body(s, box_between(-half, half), Vec3::Zero(), Quat(Eigen::AngleAxisd(0.7, Vec3(1, 1, 0).normalized())));
  add_body(s, unit_cube(), Vec3(9, 0, 0), Quat::Identity());
  update_frames(s.grains);
  const Mat3 turn = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 1, 0).normalized())).toRotationMatrix();
  const double m = 8 * half.prod(), about_y = m / 3 * (half.x() * half.x() + half.z() * half.z());
  CHECK(mobility(s.grains, 0, Vec3::Zero(), turn * Vec3::UnitZ()) == Approx(1 / m).epsilon(1e-12));
  CHECK(mobility(s.grains, 0, turn * Vec3(0.9, 0, 0.1), turn * Vec3::UnitZ()) ==
        Approx(1 / m + 0.81 / about_y).epsilon(1e-9));
  CHECK(turned_apart(s.grains, 0) == 0);
  const double least = s.grains.inertia[0].moments.minCoeff();
  set_inertia(s.grains, 0, s.grains.mass[0], 4 * s.grains.mass[0]);
  CHECK(turned_apart(s.grains, 0) == Approx(0.25 / least).epsilon(1e-12));
  CHECK((sharpness(2, 1) == 1 && sharpness(2, 5) == 2.5));
  PairLaw p;
  p.own = Foundation::Pair{.modulus = 6};
  const auto depth = [&](Index i) { return s.grains.hulls->row[s.grains.hull[i]].depth; };
  CHECK(depth(1) > 0);
  CHECK(foundation_of(p, s.grains, 1) == Approx(6 / depth(1)));
  CHECK(foundation_of(p, s.grains, 0, 1) == Approx(6 / (depth(0) + depth(1))));
  p.own = Foundation::Pair{.given = 5, .modulus = 6};
  CHECK((foundation_of(p, s.grains, 1) == 5 && foundation_of(p, s.grains, 0, 1) == 5));
}

TEST_CASE("dead loads: along their sum, or half of each where they hold each other") {
  State first, s;
  first.bonds.load = {{0, Vec3::Zero(), Vec3(0, 0, 30)}, {0, Vec3::Zero(), Vec3(0, 0, 10)}};
  const Programme test;
  CHECK((dead_loaded(test, first) && !dead_loaded(test, State{})));
  CHECK(!dead_load(test, State{}));
  s = first;
  for (DeadLoad& load : s.bonds.load) load.felt = 0.5 * load.force;
  s.bonds.load[0].point = Vec3(3, 0, 0.2), s.bonds.load[1].point = Vec3(0, 0, 1.0);
  CHECK(*dead_load(test, s) == Approx(20));
  CHECK(dead_way(first, s) == Approx(0.75 * 0.2 + 0.25 * 1.0));
  for (State* of : {&first, &s}) of->bonds.load[1].force = Vec3(0, 0, -30);
  s.bonds.load[1].felt = Vec3(0, 0, -12);  // the other one feels 15
  s.bonds.load[1].point = Vec3(0, 0, -0.4);
  CHECK(*dead_load(test, s) == Approx(13.5));
  CHECK(dead_way(first, s) == Approx(0.2 + 0.4));
}

TEST_CASE("masses that no number holds are refused, others are not; prisms take what whole ones need") {
  Material m;
  m.density = 2000;
  CHECK(unthinkable_mass(m, 1e-3).empty());
  CHECK(unthinkable_mass(m, 1e-58).empty());   // inertia 8e-287
  CHECK(!unthinkable_mass(m, 1e-59).empty());  // its inertia has left them
  CHECK(unthinkable_mass(m, 1e57).empty());    // inertia 8e288
  CHECK(!unthinkable_mass(m, 2e57).empty());
  Recipe recipe;
  recipe.box = Vec3(10, 10, 3.7);
  CHECK((voronoi_box(recipe) - recipe.box).norm() == 0);
  recipe.grains = Prisms{.side = 1, .thickness = 1};
  const Vec3 taken = voronoi_box(recipe);
  CHECK(taken.z() == Approx(3).epsilon(1e-12));
  CHECK(std::remainder(taken.x(), 0.5 * std::sqrt(3.0)) == Approx(0).margin(1e-9));  // halves of a prism's width
  CHECK((taken.x() <= 10 && taken.y() <= 10 && taken.x() > 10 - std::sqrt(3.0)));
}
