// SPDX-License-Identifier: LGPL-3.0-or-later
// Rules of one line each, by closed forms: criteria, pairs of materials, tangents at yield, the critical step's bounds.
#include "dem/bond/cohesive.hpp"
#include "dem/contact/forces.hpp"
#include "dem/fracture/break_plane.hpp"
#include "dem/fracture/grain_stress.hpp"
#include "dem/motion/critical_step.hpp"
#include "dem/rve/breakage.hpp"
#include "dem/rve/linear_response.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/tangent.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 5e-4;

/// Cubic lattice of equal spheres, compressed by `overlap` (m).
State cubic(int n, double overlap, double radius = R) {
  State s;
  const double d = 2 * radius - overlap;
  for (int i = 0; i < n * n * n; ++i)
    add(s, PolyEllipsoid::sphere(radius), d * Vec3(i % n, i / n % n, i / (n * n)), 2650);
  s.boundary.cell.vectors = n * d * Mat3::Identity();
  return s;
}

/// Grains whose halves are held by springs.
Model sprung() {
  Material m = solid(60e9, 0.17, 2650);
  FractureModel f;
  f.criteria.emplace_back(HoekBrown{592e6, 20.56});
  f.springs = CohesiveSprings{4, 1.77e6};
  m.fracture = f;
  return model_of(m);
}

/// A free grain that spins (rad/s) and has just broken in two.
State halved(const Model& model, double spin) {
  Team team(1);
  State s;
  add(s, PolyEllipsoid::sphere(3e-4), Vec3::Zero(), 2650, Vec3::Zero(), Vec3(0, spin, 0));
  prepare(model, s, team);
  apply_breaks(model, s, {across(s, 0, 0)}, team);
  return s;
}

CriticalStep step_of(const Model& model, const State& s) {
  return critical_step(model.law, model.pairs, model.materials.size(), s.grains, s.boundary, s.contacts, s.bonds);
}

}  // namespace

TEST_CASE("an axis is bad below a fifth of the longer semi-axis, and from there on it is not") {
  for (const double ratio : {0.16, 0.19, 0.21, 0.24}) {
    const PolyEllipsoid shape{Vec3(1, 1, 1), Vec3(ratio, 1, 1)};
    CHECK((choose_axis(shape, Vec3(3, 2, 1)) == 0) == (ratio > 0.2));
  }
  // Across two bad axes only where the body is 1.2 times longer along the good one.
  for (const double length : {1.15, 1.25}) {
    const PolyEllipsoid shape{Vec3(1, 1, 0.5 * length), Vec3(0.1, 0.1, 0.5 * length)};
    CHECK(choose_axis(shape, Vec3(3, 2, 1)).has_value() == (length > 1.2));
  }
}

TEST_CASE("contact tension counts as many contacts as it is told to") {
  for (const int count : {1, 3, 4, 5, 6, 7}) {
    Material m = solid(60e9, 0.17, 2650);
    FractureModel f;
    f.criteria.emplace_back(ContactTension{1.655e9, count});
    m.fracture = f;
    const Model model = model_of(m);
    Team team(1);
    for (const int axes : {2, 3}) {
      State s;
      add(s, PolyEllipsoid::sphere(3e-4), Vec3::Zero(), 2650);
      for (int k = 0; k < axes; ++k)
        for (const double side : {-1.0, 1.0}) {
          Wall wall;
          wall.material = 1, wall.shape = PlaneWall{-side * Vec3::Unit(k)},
          wall.point = Vec3(side * 0.95 * 3e-4 * Vec3::Unit(k));
          s.boundary.walls.push_back(wall);
        }
      prepare(model, s, team);
      CHECK(find_breaks(model, s, team).empty() == (2 * axes < std::max(count, 3)));  // three to make a plane
    }
  }
}

TEST_CASE(
    "two materials meet with the smaller friction, the mean restitution and both compliances; a wall by its own "
    "friction") {
  Material a = solid(60e9, 0.2, 2650, 0.3, 0.4), b = solid(20e9, 0.3, 2650, 0.5, 0.8),
           wall = solid(INFINITY, 0, 0, 0.7, 1), smooth = wall;
  smooth.friction = NAN;
  Model model;
  model.materials = {a, b, wall, smooth};
  make_pair_laws(model);
  auto law = [&](std::size_t i, std::size_t j) { return model.pairs[4 * i + j]; };
  CHECK(law(0, 1).friction[slide_spring] == 0.3);
  CHECK(law(1, 0).friction[slide_spring] == 0.3);
  CHECK(law(0, 2).friction[slide_spring] == 0.7);
  CHECK(law(2, 1).friction[slide_spring] == 0.7);
  CHECK(law(1, 3).friction[slide_spring] == 0.5);
  CHECK(1 / reduced_modulus(law(0, 1)) == Approx((1 - 0.04) / 60e9 + (1 - 0.09) / 20e9).epsilon(1e-14));
  // Mindlin: 8 G* a against 2 E* a, 1/G* the sum of (2 - nu) / G.
  const double compliance = (2 - 0.2) / (60e9 / 2.4) + (2 - 0.3) / (20e9 / 2.6);
  CHECK(law(0, 1).shear_ratio == Approx(8 / compliance / (2 * reduced_modulus(law(0, 1)))).epsilon(1e-14));
  CHECK(restitution_of(model.law, law(0, 1).dashpot) == Approx(0.6).epsilon(2e-3));
  CHECK(restitution_of(model.law, law(1, 2).dashpot) == Approx(0.8).epsilon(2e-3));
}

TEST_CASE(
    "two bodies that meet at their poles are one of them against a mirror: the elliptic factor counts there too") {
  const Model model = model_of(solid(60e9, 0.17, 2650));
  Team team(1);
  for (const Vec3& axes : {Vec3(1, 1, 1), Vec3(2, 1, 1), Vec3(0.5, 1.5, 1)}) {
    PolyEllipsoid shape;
    shape.plus = shape.minus = 1e-3 * axes;
    State pair, wall;
    for (const double side : {-1.0, 1.0}) add(pair, shape, Vec3(0, 0, side * 0.999e-3), 2650);
    add(wall, shape, Vec3(0, 0, 0.999e-3), 2650);
    add_floor(wall);
    prepare(model, pair, team), prepare(model, wall, team);
    // The mirror takes half of the overlap: F(2 d) of the pair is F(d) of the wall.
    REQUIRE(pair.contacts.contact.touching(0));
    CHECK(pair.contacts.touch[0].overlap == Approx(2 * wall.contacts.touch[0].overlap).epsilon(1e-9));
    CHECK(pair.contacts.touch[0].force.norm() == Approx(wall.contacts.touch[0].force.norm()).epsilon(1e-9));
  }
}

TEST_CASE(
    "contacts at their Coulomb limit lose the tangential stiffness in both tangents, as a strain that goes on shows") {
  const double kn = 1e6, ratio = 0.8, d = 2 * R * (1 - 1e-5);
  Model model = linear_model(kn, ratio, 2650, 0.5);
  set_damping(model, 0.3);
  model.numerics.max_energy_error = INFINITY;  // springs are set by hand
  Team team(1);
  State s = cubic(3, 2 * R * 1e-5);
  prepare(model, s, team);
  const double full = contact_stiffness_tangent(model, s)(4, 4);
  CHECK(full == Approx(ratio * kn / (2 * d)).epsilon(1e-4));
  CHECK(network_tangent(model, s)(4, 4) == Approx(0.5 * ratio * kn / d).epsilon(1e-3));
  // Contacts along z that slide in x: of the shear xz half of the bound is left, and of the network's, where grains
  // turn freely, nothing.
  auto slide = [&](int normal, int along) {
    for (std::size_t k = 0; k < s.contacts.size(); ++k) {
      const Touch& t = s.contacts.touch[k];
      if (!s.contacts.contact.touching(k) || std::abs(t.normal[normal]) < 0.5) continue;
      Contact c = s.contacts.contact[k];
      c.spring[slide_spring] =
          Vec3(-0.5 * t.force.dot(t.normal) * std::copysign(1.0, t.normal[normal]) * Vec3::Unit(along));
      s.contacts.contact.set(k, c);
    }
  };
  slide(2, 0);
  CHECK(contact_stiffness_tangent(model, s)(4, 4) == Approx(0.5 * full).epsilon(1e-4));
  CHECK(std::abs(network_tangent(model, s)(4, 4)) < 1e-3 * full);
  CHECK(network_tangent(model, s)(2, 2) == Approx(kn / d).epsilon(1e-4));
  slide(0, 2);  // and those along x in z, so that moments balance
  CHECK(std::abs(contact_stiffness_tangent(model, s)(4, 4)) < 1e-6 * full);
  // A small shear that goes on sliding, by DEM: one-sided, against both.
  QuasiStatic q;
  q.unbalanced_force = q.stress_change = 1e-6, q.pressure_floor = 1e4;
  Increment shear;
  shear.deformation(0, 2) = 2e-7;
  State moved = s;
  contact_forces(model.law, model.pairs, moved.grains, moved.boundary, 0, true, moved.contacts, team);
  drop_loads(moved.contacts);
  const double before = love_weber(moved, moved.boundary.cell.volume())(0, 2);
  const Response r = deform(model, q, moved, shear, team);
  REQUIRE(r.stable);
  CHECK(std::abs(r.stress(0, 2) - before) / 2e-7 < 0.1 * full);
}

TEST_CASE("an elastic answer ends where a grain would break, before anything slides") {
  const double overlap = 1e-3 * R;
  Material m = solid(60e9, 0.2, 2650, 10);
  FractureModel f;
  f.criteria.emplace_back(HoekBrown{1e6, 20});
  m.fracture = f;
  Model model = model_of(m);
  Team team(1);
  State s = cubic(3, overlap);
  prepare(model, s, team);
  s.boundary.cell.rate.setZero();
  // Equal stresses break nothing; an axial strain of 1e-5 takes the stress along z up by 1.5 of it over the overlap.
  const double force = s.contacts.touch[0].force.norm(), strain = 2e-5, more = 1.5 * force * strain * (2 * R) / overlap;
  REQUIRE(more < 0.1 * force);
  const double deviator = more * R / (4 * pi / 3 * std::pow(R, 3)) * 2,
               s3 = 2 * R * force / (4 * pi / 3 * std::pow(R, 3));
  Vec6 squeeze = Vec6::Zero();
  squeeze[2] = -strain;
  for (const double part : {0.9, 1.1}) {
    // sigma_1 - sigma_3 = c sqrt(m sigma_3 / c + 1), solved for the strength c that is just reached at `part` of the
    // deviator.
    const double d = part * deviator, half = 20 * s3 / 2, c = -half + std::sqrt(half * half + d * d);
    criterion<HoekBrown>(model).compressive_strength = c;
    const auto r = linear_response(model, s, 0.5);
    REQUIRE(r);
    CHECK(r->holds(model, squeeze, 0.5) == (part > 1));
  }
}

TEST_CASE("an elastic answer ends where a gap would close") {
  const Model model = linear_model(1e6, 0.8, 2650, 10);
  Team team(1);
  State s = cubic(3, 1e-3 * R);
  const double gap = 1e-5 * R, wider = (2 * R + gap) / (2 * R - 1e-3 * R);
  s.boundary.cell.vectors(0, 0) *= wider;
  for (auto& m : s.grains.motion) m.position.x() *= wider;
  prepare(model, s, team);
  const auto r = linear_response(model, s, 0);
  REQUIRE(r);
  for (const double part : {0.5, 1.5}) {
    Vec6 squeeze = Vec6::Zero();
    squeeze[0] = -part * gap / (2 * R + gap);
    CHECK(r->holds(model, squeeze, 0) == (part < 1));
  }
}

TEST_CASE("the tension of a contact is Hertz's at its rim, for grains that break and for points that are elastic") {
  // sigma = (1 - 2 nu) / 3 x 3 F / (2 pi a^2), a^2 = R_e overlap; three contacts of a cubic lattice reach it together.
  const double overlap = 2e-3 * R, force = 4.0 / 3 * 30e9 / 0.96 * std::sqrt(R / 2) * std::pow(overlap, 1.5);
  const double tension = (1 - 2 * 0.2) / 3 * 1.5 * force / (pi * R / 2 * overlap);
  for (const double part : {0.99, 1.01}) {
    Material m = solid(60e9, 0.2, 2650, 10);
    FractureModel f;
    f.criteria.emplace_back(ContactTension{part * tension, 3});
    m.fracture = f;
    Model model = model_of(m);
    Team team(1);
    State s = cubic(3, overlap);
    prepare(model, s, team);
    CHECK(find_breaks(model, s, team).empty() == (part > 1));
    // An isotropic strain adds 3 / 2 e 2 R / overlap to each force, a third of that to each tension.
    criterion<ContactTension>(model).strength = 1.02 * tension;
    const auto r = linear_response(model, s, 0.5);
    REQUIRE(r);
    Vec6 squeeze = Vec6::Zero();
    squeeze.head<3>().setConstant(-(part > 1 ? 0.021 : 0.019) * 2 * overlap / (2 * R));
    CHECK(r->holds(model, squeeze, 0.5) == (part < 1));
  }
}

TEST_CASE(
    "fabric, coordination, void ratio, unbalanced force and inertial number of a lattice are what counting says") {
  const Model model = linear_model(1e6, 0.8, 2650, 0.5);
  Team team(1);
  State s = cubic(3, 1e-3 * R);
  s.boundary.cell.vectors(2, 2) *= 0.9995;  // pressed more along z: forces differ, directions do not
  for (auto& m : s.grains.motion) m.position.z() *= 0.9995;
  prepare(model, s, team);
  const Measurement m = measure(model, s);
  CHECK((m.fabric - Mat3::Identity() / 3).norm() < 1e-12);
  CHECK(m.coordination == Approx(6));
  const double solid_volume = 27 * 4 * pi / 3 * R * R * R, cell = s.boundary.cell.vectors.determinant();
  CHECK(m.void_ratio == Approx(cell / solid_volume - 1).epsilon(1e-12));
  CHECK(m.solid_fraction == Approx(solid_volume / cell).epsilon(1e-12));
  for (auto& f : s.grains.force) f = Vec3(0.3, 0, 0.4);
  double contacts = 0, forces = 0;
  for (std::size_t k = 0; k < s.contacts.size(); ++k)
    if (s.contacts.contact.touching(k)) ++contacts, forces += s.contacts.touch[k].force.norm();
  CHECK(measure(model, s).unbalanced_force == Approx(0.5 / (forces / contacts)).epsilon(1e-12));
  for (auto& mass : s.grains.mass) mass *= 2;
  CHECK(inertial_number(s, -7, 1e5) == Approx(7 * 2 * R * std::sqrt(2 * 2650 / 1e5)).epsilon(1e-12));
}

TEST_CASE("the critical step sees an impact coming: both grains' speeds, and Hertz's depth") {
  const Model model = model_of(solid(60e9, 0.2, 2650));
  Team team(1);
  State s;
  for (const double side : {-1.0, 1.0})
    add(s, PolyEllipsoid::sphere(R), Vec3(side * 1.1 * R, 0, 0), 2650, Vec3(-side * 3, 0, 0));
  prepare(model, s, team);
  // Depth of an impact at 6 m/s of half the mass on R / 2: 15 m v^2 / (16 E* sqrt R) to the power 2/5; stiffness 2 E*
  // sqrt(R depth).
  const double mass = 0.5 * s.grains.mass[0], youngs = 30e9 / 0.96, radius = R / 2, v = 6;
  const double depth = std::pow(15 * mass * v * v / (16 * youngs * std::sqrt(radius)), 0.4),
               stiffness = 2 * youngs * std::sqrt(radius * depth);
  CHECK(step_of(model, s).dt == Approx(2 / std::sqrt(stiffness / mass)).epsilon(1e-9));
}

TEST_CASE("springs of a fresh plane shorten the critical step") {
  const Model model = sprung();
  State s = halved(model, 10);
  double stiffness = 0;
  for (const auto& b : s.bonds.cohesive.row) stiffness += b.peak / b.onset;
  const CriticalStep with = step_of(model, s);
  s.bonds.clear();
  // Two halves on springs swing at sqrt(2 k / m) at least, the smaller half's; the bound doubles each grain's own k /
  // m.
  double least = INFINITY;
  for (const double mass : s.grains.mass) least = std::min(least, mass);
  CHECK(with.dt <= 2 / std::sqrt(2 * stiffness / least) * (1 + 1e-9));
  CHECK(step_of(model, s).dt > 1.05 * with.dt);
}

TEST_CASE("potentials are the integrals of their forces: contacts of both laws, tangential and cohesive springs") {
  for (const ContactLaw& law : {ContactLaw{HertzMindlin{}}, ContactLaw{LinearSpring{}}})
    for (const double overlap : {1e-7, 1e-5}) {
      const double h = 1e-3 * overlap;
      Contact c;
      c.stiffness = 3e7;
      const auto at = [&](double x) { return std::visit([&](const auto& l) { return l(c, x); }, law); };
      CHECK((at(overlap + h).energy - at(overlap - h).energy) / (2 * h) == Approx(at(overlap).force).epsilon(1e-6));
      CHECK((at(overlap + h).force - at(overlap - h).force) / (2 * h) ==
            Approx(at(overlap).normal_stiffness).epsilon(1e-6));
    }
  // A cohesive spring between two fixed halves: held energy changes by minus force times way, and what softens is
  // booked.
  State s = halved(sprung(), 2000);
  Team team(1);
  REQUIRE(s.bonds.size() == 4);
  double reach = 0;
  for (const auto& b : s.bonds.cohesive.row) reach = std::max(reach, b.rupture);
  const Vec3 way = 1e-4 * reach * Vec3(1, 0.3, -0.2).normalized();
  double work = 0;
  bond_forces(s.grains, s.boundary.cell, s.bonds, s.ledger, team);
  const double start = stored_energy(s.bonds) + s.ledger.fracture;
  for (int k = 0; k < 5000; ++k) {
    const Vec3 before = s.grains.force[0];
    s.grains.motion[0].position += (k < 3000 ? 1 : -1) * way;
    bond_forces(s.grains, s.boundary.cell, s.bonds, s.ledger, team);
    work -= 0.5 * (before + s.grains.force[0]).dot((k < 3000 ? 1 : -1) * way);
  }
  CHECK(s.ledger.fracture > 0);
  CHECK(stored_energy(s.bonds) + s.ledger.fracture - start == Approx(work).epsilon(1e-3));
}

TEST_CASE("a body on its flat side rolls against the force's lever: the critical step knows it") {
  // A lens pressed between two planes along its short axis: m w^2 of its rocking = (k_t h^2 + F (r - h)) / I, r the
  // radius of the flat.
  PolyEllipsoid lens;
  lens.plus = lens.minus = Vec3(1e-3, 1e-3, 0.1e-3);
  Model model = model_of(solid(60e9, 0.17, 2650));
  Team team(1);
  State s;
  add(s, lens, Vec3::Zero(), 2650);
  for (const double side : {-1.0, 1.0}) {
    Wall wall;
    wall.material = 1, wall.shape = PlaneWall{Vec3(0, 0, -side)}, wall.point = Vec3(0, 0, side * 0.05e-3);
    s.boundary.walls.push_back(wall);
  }
  prepare(model, s, team);
  double force = 0, normal = 0;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    force += s.contacts.touch[k].force.norm();
    normal += HertzMindlin{}(s.contacts.contact[k], s.contacts.touch[k].overlap).normal_stiffness;
  }
  const double radius = 1e-3 * 1e-3 / 0.1e-3, inertia = s.grains.mass[0] * (1e-6 + 0.01e-6) / 5;
  const double rocking = force * (radius - 0.1e-3) / inertia, bouncing = normal / s.grains.mass[0];
  REQUIRE(rocking > 1.2 * bouncing);
  const double dt = step_of(model, s).dt;
  CHECK(dt <= 2 / std::sqrt(rocking) * (1 + 1e-9));
  CHECK(dt >
        0.5 / std::sqrt(rocking));  // sum of both principal radii instead of one: at most the root of two, twice here
}

TEST_CASE("no grain goes further in a step than a twentieth of its least width, spin included") {
  Model model = model_of(solid(1e4, 0.2, 2650));  // so soft that stiffness sets no step
  Team team(1);
  for (const bool spins : {false, true}) {
    State s;
    PolyEllipsoid shape;
    shape.plus = shape.minus = Vec3(2e-3, 1e-3, 0.5e-3);
    add(s, shape, Vec3::Zero(), 2650, spins ? Vec3(0, 0, 0) : Vec3(50, 0, 0), spins ? Vec3(0, 0, 5e4) : Vec3(0, 0, 0));
    prepare(model, s, team);
    const double speed = spins ? 5e4 * s.grains.motion[0].radius : 50;
    CHECK(step_of(model, s).dt == Approx(0.05 * 1e-3 / speed).epsilon(1e-12));
  }
}
