// SPDX-License-Identifier: LGPL-3.0-or-later
// Grains that cleave: tractions on planes by closed forms, the mixed mode, what a cut conserves, and its bond.
#include "dem/fracture/cleavage.hpp"
#include "dem/bond/face_bond.hpp"
#include "dem/fracture/hull_loads.hpp"
#include "dem/io/archive.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/bonded.hpp"
#include "tests/cleaving_cells.hpp"
#include "tests/hulls.hpp"
#include "tests/loaded_body.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// One prism of 4 x 1 x 1 along x, and forces on points of it.
State prism(const Model& model, const PointLoads& loads) {
  return loaded_body(model, box_between(Vec3(-2, -0.5, -0.5), Vec3(2, 0.5, 0.5)), loads);
}

const Cleavage& cleavage_of(const Model& model) { return std::get<Cleavage>(model.materials[0].fracture->criteria[0]); }

const std::vector<Cleavage::Plane> across_x{{Vec3::UnitX(), toughness}};

}  // namespace

TEST_CASE("a prism pulled at both ends cleaves at Y sigma sqrt(pi a) = K_Ic, sheared at 0.816 of it, else by the mix") {
  const Model model = cleaving_rock(false, across_x);
  // Shear by loads at both sides of the middle, which no mean stress tells of: a squeeze in the plane makes it look.
  const auto at = [&](double tension, double shear) {
    const double t = tension * strength, v = shear * strength, d = 1e-9;
    const State s = prism(model, {{Vec3(2, 0, 0), Vec3(t, 0, 0)},
                                  {Vec3(-2, 0, 0), Vec3(-t, 0, 0)},
                                  {Vec3(d, 0, 0), Vec3(0, v, 0)},
                                  {Vec3(-d, 0, 0), Vec3(0, -v, 0)},
                                  {Vec3(0, 0, 0.5), Vec3(0, 0, -9 * strength)},
                                  {Vec3(0, 0, -0.5), Vec3(0, 0, 9 * strength)}});
    return cleavage_of(model).worst(loaded_hull(model, s, 0), 1).utilisation;
  };
  CHECK(at(1, 0) == Approx(1).epsilon(1e-9));
  CHECK(at(0, 0.816) == Approx(1).epsilon(1e-6));
  for (const double k1 : {0.5, 0.75, 0.9}) {
    const double k2 = 0.816 * std::sqrt(1 - k1);  // .577, .408, .258
    CHECK(at(k1, k2) == Approx(1).epsilon(1e-6));
    CHECK(at(2 * k1, 2 * k2) == Approx(2).epsilon(1e-6));
  }
  CHECK(at(-5, 0) == 0);
  CHECK(at(-5, 0.816) == Approx(1).epsilon(1e-6));
  const State s =
      prism(model, {{Vec3(2, 0, 0), Vec3(1.01 * strength, 0, 0)}, {Vec3(-2, 0, 0), Vec3(-1.01 * strength, 0, 0)}});
  State now = s;
  Team team(1);
  REQUIRE(find_breaks(model, now, team).size() == 1);
}

TEST_CASE("tractions of a prism in motion: pulled at one end, bent, twisted, spinning") {
  const Model model = cleaving_rock(false, across_x);
  const auto on = [](const PlaneLoad& load, int k) { return load.force[k]; };
  // Pulled at one end by F: at x the part beyond needs its share of the mass times F / m.
  const State pulled = prism(model, {{Vec3(2, 0, 0), Vec3(8, 0, 0)}});
  for (const double x : {-1.0, 0.0, 1.5}) {
    const PlaneLoad load = loaded_hull(model, pulled, 0).across_plane(Vec3::UnitX(), x);
    CHECK(on(load, 0) == Approx(-8 * (2 + x) / 4).epsilon(1e-9));
    CHECK(load.share == Approx(std::min(2 - x, 2 + x) / 4));
    CHECK(load.moment.norm() < 1e-9);
  }
  // Three-point bending: the middle bears P L / 4.
  const State bent =
      prism(model,
            {{Vec3(0, 0.5, 0), Vec3(0, -6, 0)}, {Vec3(2, -0.5, 0), Vec3(0, 3, 0)}, {Vec3(-2, -0.5, 0), Vec3(0, 3, 0)}});
  const PlaneLoad mid = loaded_hull(model, bent, 0).across_plane(Vec3::UnitX(), 1e-9);
  CHECK(mid.moment.z() == Approx(-6).epsilon(1e-6));
  CHECK(on(mid, 1) == Approx(-3).epsilon(1e-6));
  // Largest tension M h / (2 I) = 6 M, and the shear.
  const Cleft cleft = [&] {
    Model weak = model;
    std::get<Cleavage>(weak.materials[0].fracture->criteria[0]).toughness = 1e-3;
    std::get<Cleavage>(weak.materials[0].fracture->criteria[0]).planes[0].toughness = 1e-3;
    std::get<Cleavage>(weak.materials[0].fracture->criteria[0]).offsets = {1e-9};
    return cleavage_of(weak).worst(loaded_hull(weak, bent, 0), 1);
  }();
  CHECK(cleft.tension == Approx(36).epsilon(1e-6));
  CHECK(cleft.shear == Approx(3).epsilon(1e-6));
  // Spinning about z at w: rho w^2 (L^2 - x^2) / 2 of tension.
  State spinning = prism(model, {});
  spinning.grains.motion[0].spin = Vec3(0, 0, 3);
  spinning.grains.angular_momentum[0] = inertia_tensor(spinning.grains, 0) * Vec3(0, 0, 3);
  for (const double x : {-0.5, 0.0, 1.0})
    CHECK(on(loaded_hull(model, spinning, 0).across_plane(Vec3::UnitX(), x), 0) ==
          Approx(-9 * (4 - x * x) / 2).epsilon(1e-9));
}

TEST_CASE("contacts and bonds of cells add up to their forces; both sides of a plane tell the same") {
  Team team(1);
  BondModel bond = cohesive(2e5, 40);
  bond.damping = 0.1;
  for (const bool bonded : {true, false}) {
    Model model = cleaving_rock(false, {}, bond);
    if (!bonded) model.materials[0].bond.reset();
    State s;
    s.boundary.cell.vectors = 5 * Mat3::Identity();
    add_voronoi_grains(model, voronoi_packing(periodic_space(Vec3::Constant(5)), 125, 3, 1, team), 0, s);
    model.materials[0].fracture->limit.max_generations = 0;  // all stay whole
    prepare(model, s, team);
    Mat3 rate = Mat3::Zero();
    rate(2, 2) = -20, rate(0, 1) = 15;
    set_cell_rate(s, rate);
    run_steps(model, s, 60, team);
    index_bonds(s.grains.size(), s.bonds, s.break_room.bonds);
    double largest = 0;
    for (std::size_t i = 0; i < s.grains.size(); ++i)
      largest = std::max(largest, loaded_hull(model, s, i).largest_force());
    REQUIRE(largest > 0);
    for (std::size_t i = 0; i < s.grains.size(); ++i) {
      const LoadedHull g = loaded_hull(model, s, i);
      CHECK(g.imbalance().norm() < 1e-11 * largest);
      Vec3 torque = -s.grains.torque[i];
      g.each_load([&](const HullLoad& l) { torque += l.couple + l.at.cross(l.force); });
      CHECK(torque.norm() < 1e-11 * largest);
      for (std::uint64_t k = 0; k < 4; ++k) {
        const Vec3 n = random_vector(i, k).normalized();
        const PlaneLoad one = g.across_plane(n, 0.07), other = g.across_plane(-n, -0.07);
        CHECK((one.middle - other.middle).norm() < 1e-11);
        CHECK((one.force + other.force).norm() < 1e-9 * largest);
        CHECK((one.moment + other.moment).norm() < 1e-9 * largest);
      }
    }
  }
}

TEST_CASE("a cube pressed between its faces is not sheared on planes along the load; across them it bears it") {
  Model model = cleaving_rock(false, {{Vec3::UnitX(), toughness}, {Vec3::UnitZ(), toughness}});
  State s;
  add_body(s, unit_cube(), Vec3::Zero(), Quat::Identity());
  for (int side = 0; side < 2; ++side) {
    Wall wall;
    wall.material = 1, wall.shape = PlaneWall{Vec3(0, 0, side ? -1 : 1)}, wall.point = -(0.5 - 1e-4) * wall.facing();
    s.boundary.walls.push_back(wall);
  }
  Team team(1);
  prepare(model, s, team);
  run_steps(model, s, 1, team);
  index_bonds(1, s.bonds, s.break_room.bonds);
  const LoadedHull g = loaded_hull(model, s, 0);
  const double load = g.largest_force();
  REQUIRE(load > 1);
  const PlaneLoad along = g.across_plane(Vec3::UnitX(), 0), across_it = g.across_plane(Vec3::UnitZ(), 0);
  CHECK(along.force.norm() < 1e-6 * load);
  CHECK(across_it.force.z() == Approx(load).epsilon(1e-3));
}

TEST_CASE("a cut keeps mass, momentum, angular momentum, energy and second moments; pieces move as their parent") {
  Team team(1);
  for (std::uint64_t k = 0; k < 50; ++k) {
    Model model = cleaving_rock(false);
    model.materials[0].density = 1;
    State s;
    add_body(s, some_cells(64).body[k], random_vector(k, 0), random_rotation(3, k), random_vector(k, 1),
             random_vector(k, 2));
    prepare(model, s, team);
    const Grains before = s.grains;
    const Vec3 n = random_vector(k, 3).normalized();
    apply_breaks(model, s, {{0, {Mat3::Zero(), n, Vec3::Zero(), 0.05 * random_uniform(1, k, Purpose::turn)}}}, team);
    REQUIRE(s.grains.size() == 2);
    const Grains& g = s.grains;
    CHECK(std::abs(total_mass(g) / total_mass(before) - 1) < 1e-12);
    CHECK((momentum(g) - momentum(before)).norm() < 1e-12 * momentum(before).norm());
    CHECK((angular_momentum(g) - angular_momentum(before)).norm() < 1e-12 * angular_momentum(before).norm());
    CHECK(std::abs(kinetic_energy(g) / kinetic_energy(before) - 1) < 1e-12);
    const auto inertia = [](const Grains& of) {
      Mat3 sum = Mat3::Zero();
      for (std::size_t i = 0; i < of.size(); ++i) {
        const Vec3 x = of.motion[i].position;
        sum += inertia_tensor(of, i) + of.mass[i] * (x.squaredNorm() * Mat3::Identity() - x * x.transpose());
      }
      return sum;
    };
    CHECK((inertia(g) - inertia(before)).norm() < 1e-12 * inertia(before).norm());
    CHECK(s.ledger.fines.mass == Approx(0).margin(1e-15));
    CHECK(s.ledger.breakages == 1);
  }
}

TEST_CASE("the bond of a fresh face is born with what the plane carried: nothing jumps") {
  Team team(1);
  for (const bool bonded : {true, false}) {
    Model model = cleaving_rock(true);
    if (!bonded) model.materials[0].bond.reset();
    model.materials[0].fracture->splitter = Cut{true, bonded ? 200.0 : 1e6};
    State s;
    s.boundary.cell.vectors = 5 * Mat3::Identity();
    add_voronoi_grains(model, voronoi_packing(periodic_space(Vec3::Constant(5)), 125, 3, 1, team), 0, s);
    std::get<Cleavage>(model.materials[0].fracture->criteria[0]).toughness = 1e30;
    prepare(model, s, team);
    Mat3 rate = Mat3::Zero();
    rate(2, 2) = bonded ? -0.02 : -20, rate(0, 1) = bonded ? 0.015 : 15;
    set_cell_rate(s, rate);
    run_steps(model, s, 60, team);
    for (const std::size_t i : {3u, 50u, 90u}) {
      State now = s;
      const Vec3 n = random_vector(i, 3).normalized();
      const Vec3 linear = now.grains.force[i] / now.grains.mass[i], spin = spin_of(now.grains, i);
      const Vec3 angular =
          inertia_tensor(now.grains, i).inverse() * (now.grains.torque[i] - spin.cross(now.grains.angular_momentum[i]));
      const Vec3 x = now.grains.motion[i].position;
      double scale = 0;  // accelerations of the cells
      for (std::size_t j = 0; j < now.grains.size(); ++j)
        scale = std::max(scale, now.grains.force[j].norm() / now.grains.mass[j]);
      const std::size_t bonds = now.bonds.size();
      const double stored = stored_energy(model, now), residual = now.ledger.residual_force;
      apply_breaks(model, now, {{i, {Mat3::Zero(), n, Vec3::Zero(), 0.03}}}, team);
      REQUIRE(now.grains.size() == 126);
      CHECK(now.bonds.size() > bonds + (bonded ? 2 : 0));
      const double largest = now.grains.mass[i] * scale;
      // Contacts are pressed anew by each piece, whose planes may be others; bonds are cut exactly.
      const double jump = now.ledger.residual_force - residual;
      if (bonded) CHECK(jump < 1e-9 * largest);
      for (const std::size_t piece : {i, std::size_t{125}}) {
        if (!bonded) break;
        const Vec3 d = now.grains.motion[piece].position - x;
        const Vec3 expected = linear + angular.cross(d) + spin.cross(spin.cross(d));
        CHECK((now.grains.force[piece] / now.grains.mass[piece] - expected).norm() < 1e-9 * scale);
        const Vec3 turned = inertia_tensor(now.grains, piece).inverse() *
                            (now.grains.torque[piece] - spin.cross(now.grains.angular_momentum[piece]));
        CHECK((turned - angular).norm() < 1e-5 * scale);  // a bond's parts turn about their own middles: of its angle
      }
      // What it holds is booked; all else is as it was.
      const double gained = stored_energy(model, now) - stored;
      CHECK(std::abs(gained + now.ledger.split - s.ledger.split + now.ledger.fracture - s.ledger.fracture) <
            1e-9 * stored);
    }
  }
}

TEST_CASE("cells that cleave at the seam of a periodic cell, bonded or not: energy, any threads, saved and read") {
  for (const bool bonded : {true, false}) {
    Model model = cleaving_rock(true, {{Vec3::UnitX(), 1e5}, {Vec3(0.6, 0.8, 0), 2e5}}, cohesive(2e6, 2e4));
    if (!bonded) model.materials[0].bond.reset();
    model.materials[0].fracture->splitter = Cut{true, 2e3};
    model.materials[0].fracture->limit.max_generations = 2;
    model.materials[0].fracture->crystal = Crystal{};
    const std::uint64_t steps = 80;  // by then every cell has been cut twice, bonded or not
    const State one = crushed(model, 1, steps);
    INFO(one.ledger.breakages);
    CHECK(one.ledger.breakages == 3 * 64);
    CHECK(one.grains.size() == 64 + one.ledger.breakages);
    CHECK(std::abs(total_mass(one.grains) / (density * 64) - 1) < 1e-10);
    CHECK(std::abs(energy_error(one.ledger, stored_energy(model, one))) < 0.01);
    CHECK(one.ledger.fracture > 0);
    CHECK(one.grains.crystal.size() == one.grains.size());
    std::size_t seam = 0;
    for (const FaceBond& b : one.bonds.face.row) seam += (b.ends.image[0] | b.ends.image[1] | b.ends.image[2]) != 0;
    if (bonded) CHECK(seam > 10);
    CHECK(hash(crushed(model, 2, steps)) == hash(one));
    CHECK(hash(crushed(model, 1, steps, true)) == hash(one));
  }
}

TEST_CASE("a softened bond in parts: no part of it gains energy, whatever it has gone through") {
  Team team(1);
  const Model model = rock(cohesive(1e5, 40), 0.5);
  State s;
  s.boundary.cell.vectors = 4 * Mat3::Identity();
  add_voronoi_grains(model, voronoi_packing(periodic_space(Vec3::Constant(4)), 64, 3, 1, team), 0, s);
  prepare(model, s, team);
  Mat3 rate = Mat3::Zero();
  rate(0, 0) = 0.02, rate(2, 2) = -0.05, rate(0, 1) = 0.03;
  set_cell_rate(s, rate);
  for (std::size_t damaged = 0; damaged < 30 && s.steps < 5000;) {
    run_steps(model, s, 20, team);
    damaged = static_cast<std::size_t>(std::count_if(s.bonds.face.row.begin(), s.bonds.face.row.end(),
                                                     [](const FaceBond& b) { return b.damage > 0; }));
  }
  std::size_t damaged = 0;
  for (const FaceBond& b : s.bonds.face.row) {
    if (b.damage == 0) continue;
    ++damaged;
    const FlatPolygon p = polygon_of(s.grains, b, false);
    const Quat turn = s.grains.orientation[b.ends.a].conjugate() * s.grains.orientation[b.ends.b] * b.rest;
    double parts = 0;
    for (const double side : {1.0, -1.0}) {
      const FlatMoments part = moments_of(clipped(p, side * Eigen::Vector2d(0.6, 0.8), 0));
      if (!(part.area > 0)) continue;
      FaceBond row = part_of(b, part, turn);
      const double spent = row.spent;
      pull(row, frame_of(s.grains, s.boundary.cell, b.ends), {&s.grains});
      parts += energy(row) + row.spent - spent;
    }
    FaceBond whole = b;
    const double spent = whole.spent;
    pull(whole, frame_of(s.grains, s.boundary.cell, b.ends), {&s.grains});
    CHECK(parts <= (1 + 1e-9) * (energy(whole) + whole.spent - spent));
  }
  CHECK(damaged > 20);
}
