// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls that nothing bonds, one pass of contacts at a time, by closed forms: across the seam of a strained cell, on
// moving walls, of two materials, spinning one against one at rest, thick on thin, deep in each other; layers of them
// in a cell that shears.
#include "dem/contact/forces.hpp"
#include "dem/rve/measure.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double dt = 1e-4;

/// What one pass does: the first contact, loads of both grains, energies.
struct Pass {
  Contact contact;
  Touch touch;
  Load a, b;
  BlockEnergy energy;
};

Pass pass(const Model& model, State& s) {
  Team team(1);
  contact_forces(model.law, model.pairs, s.grains, s.boundary, dt, true, s.contacts, team);
  REQUIRE(s.contacts.size() > 0);
  Pass p{s.contacts.contact[0], s.contacts.touch[0], s.contacts.plan.load[0], {}, {}};
  if (s.grains.size() > 1) p.b = s.contacts.plan.load[1];
  drop_loads(s.contacts);
  p.energy = flush(s.contacts);
  return p;
}

void ready(const Model& model, State& s) {
  Team team(1);
  prepare(model, s, team);
}

/// Two unit cubes, b on the +x side of a, an overlap deep in each other.
State two_cubes(double overlap) {
  State s;
  add_body(s, unit_cube(), Vec3::Zero(), Quat::Identity());
  add_body(s, unit_cube(), Vec3(1 - overlap, 0, 0), Quat::Identity());
  return s;
}

/// Radius of gyration of the surface of a unit cube within its partner: the face, and of its sides what is in there.
double arm_of(double overlap) { return std::sqrt(1.0 / 6 + 4 * overlap * (1 + overlap * overlap) / 3); }

}  // namespace

TEST_CASE("hulls across the seam of a strained cell: friction and work by the velocity of the image") {
  // Grains at rest, b's image one edge to the left of it: that moves by -rate, a by nothing.
  for (const double v : {1e-3, 1e3}) {  // far below Coulomb's limit, far beyond
    const Model model = hull_model(0.3);
    State s;
    s.boundary.cell.vectors = 5 * Mat3::Identity();
    add_body(s, unit_cube(), Vec3(0.45, 2, 2), Quat::Identity());
    add_body(s, unit_cube(), Vec3(4.55, 2, 2), Quat::Identity());
    ready(model, s);
    s.boundary.cell.rate(1, 0) = v, s.boundary.cell.rate(0, 0) = 0.1 * v;
    const Pass p = pass(model, s);
    const double normal = modulus * 0.1, stuck = 0.5 * modulus * dt * v, shear = std::min(stuck, 0.3 * normal);
    CAPTURE(v);
    CHECK((p.b.force - Vec3(-normal, shear, 0)).norm() < 1e-9 * normal);
    CHECK((p.a.force + p.b.force).norm() < 1e-9 * normal);
    CHECK(p.energy.work == Approx(dt * (shear * v - 0.1 * normal * v)).epsilon(1e-9));
    // The middle of the contact, where a has its face: half a side from a, and from the image of b less the overlap.
    CHECK(p.a.torque.z() == Approx(0.5 * shear).margin(1e-11 * normal));  // round-off of the elastic moment
    CHECK(p.b.torque.z() == Approx(0.4 * shear).margin(1e-11 * normal));
    const double slipped = (stuck - shear) / (0.5 * modulus);
    CHECK(p.energy.friction == Approx(0.5 * shear * slipped).epsilon(1e-6).margin(1e-12));
  }
}

TEST_CASE("a cube on a floor that moves along itself is dragged by mu m g, and the floor works against it") {
  Model model = hull_model(0.2, 1e4);
  model.numerics.time_step = 1e-4;
  model.motion.gravity = Vec3(0, 0, -1);
  State s;
  add_body(s, unit_cube(), Vec3(0, 0, 0.5 - 1e-4), Quat::Identity());
  add_floor(s);
  s.boundary.walls[0].velocity = Vec3(3, 0, 0);
  ready(model, s);
  Team team(1);
  run_for(model, s, 1, team);
  // The cube rocks, hardly damped: what it is pressed with swings about its weight.
  CHECK(s.grains.motion[0].velocity.x() == Approx(0.2).epsilon(0.02));
  CHECK(s.ledger.work == Approx(0.2 * 3).epsilon(0.02));
  CHECK(s.ledger.friction == Approx(0.2 * (3 - 0.1)).epsilon(0.02));
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 2e-3);
}

TEST_CASE(
    "hulls of two materials: foundations in series, the lower friction, the mean shear ratio; one alone at walls") {
  Model model = hull_model(0.5, 1e6);
  Material other = model.materials[0];
  other.contact = Foundation::Of{.given = 3e6, .shear_ratio = 0.9}, other.friction = 0.2, other.name = "other";
  model.materials.push_back(other);
  make_pair_laws(model);
  State s = two_cubes(0.01);
  s.grains.material[1] = 2;
  ready(model, s);
  s.grains.motion[1].velocity = Vec3(0, 1e-3, 0);
  const double c = 2 * 1e6 * 3e6 / 4e6;
  const Pass stuck = pass(model, s);
  CHECK(stuck.b.force.x() == Approx(c * 0.01).epsilon(1e-9));
  CHECK(stuck.b.force.y() == Approx(-0.7 * c * 1e-3 * dt).epsilon(1e-9));
  s.grains.motion[1].velocity = Vec3(0, 1e3, 0);
  CHECK(pass(model, s).b.force.y() == Approx(-0.2 * c * 0.01).epsilon(1e-9));

  State wall;
  add_body(wall, unit_cube(), Vec3(0, 0, 0.49), Quat::Identity());
  wall.grains.material[0] = 2;
  add_floor(wall);
  ready(model, wall);
  wall.grains.motion[0].velocity = Vec3(1e-3, 0, 0);
  const Pass alone = pass(model, wall);
  CHECK(alone.a.force.z() == Approx(3e6 * 0.01).epsilon(1e-9));
  CHECK(alone.a.force.x() == Approx(-0.9 * 3e6 * 1e-3 * dt).epsilon(1e-9));
}

TEST_CASE("thick on thin: a modulus acts over both depths, at a wall over the hull's own") {
  Model model = hull_model();
  model.materials[0].contact = Foundation::Of{.modulus = 1e6, .shear_ratio = 0.5};
  make_pair_laws(model);
  // Three volumes over the surface: of the unit cube a half, of a plate of a tenth 0.3 / 2.4.
  const Polyhedron plate = box_between(Vec3(-0.05, -0.5, -0.5), Vec3(0.05, 0.5, 0.5));
  for (const bool thin_first : {false, true}) {
    State s;
    add_body(s, thin_first ? plate : unit_cube(), Vec3::Zero(), Quat::Identity());
    add_body(s, thin_first ? unit_cube() : plate, Vec3(0.549, 0, 0), Quat::Identity());
    ready(model, s);
    CHECK(pass(model, s).b.force.x() == Approx(1e6 / 0.625 * 1e-3).epsilon(1e-9));
  }
  State s;
  add_body(s, plate, Vec3(0, 0, 0.499), Quat::Identity());
  add_floor(s);
  ready(model, s);
  CHECK(pass(model, s).a.force.z() == Approx(1e6 / 0.125 * 0.1 * 1e-3).epsilon(1e-9));
}

TEST_CASE("one hull spins, the other does not: springs turn by half of it, and friction about the normal has its arm") {
  constexpr double overlap = 0.01, v = 1e-3, spin = 5;
  const double kt = 0.5 * modulus, arm = arm_of(overlap);
  const Model model = hull_model(1e3);
  for (const auto& [of_a, of_b] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {1.0, 1.0}}) {
    State s = two_cubes(overlap);
    ready(model, s);
    s.grains.motion[1].velocity = Vec3(0, v, 0);
    const double shear = kt * dt * v;
    CHECK((pass(model, s).contact.spring[slide_spring] - Vec3(0, -shear, 0)).norm() < 1e-9 * shear);
    s.grains.motion[1].velocity.setZero();
    s.grains.motion[0].spin = Vec3(of_a * spin, 0, 0), s.grains.motion[1].spin = Vec3(of_b * spin, 0, 0);
    const Pass p = pass(model, s);
    const double angle = std::atan(0.5 * (of_a + of_b) * spin * dt), twist = kt * arm * (of_b - of_a) * spin * dt;
    CAPTURE(of_a, of_b);
    CHECK((p.contact.spring[slide_spring] - Vec3(-twist, -shear * std::cos(angle), -shear * std::sin(angle))).norm() <
          1e-9 * (shear + std::abs(twist)));
    CHECK(p.b.torque.x() == Approx(-arm * twist).epsilon(1e-9).margin(1e-9 * arm * shear));
    CHECK(p.a.torque.x() == Approx(arm * twist).epsilon(1e-9).margin(1e-9 * arm * shear));
  }
  // On a wall, which does not turn: half of the grain's own.
  State s;
  add_body(s, unit_cube(), Vec3(0, 0, 0.49), Quat::Identity());
  add_floor(s);
  ready(model, s);
  s.grains.motion[0].velocity = Vec3(v, 0, 0);
  const double shear = kt * dt * v;
  CHECK(pass(model, s).a.force.x() == Approx(-shear).epsilon(1e-9));
  s.grains.motion[0].velocity.setZero(), s.grains.motion[0].spin = Vec3(0, 0, spin);
  const Pass p = pass(model, s);
  CHECK(p.a.force.y() / p.a.force.x() == Approx(0.5 * spin * dt).epsilon(1e-6));
  CHECK(p.a.torque.z() == Approx(-kt * arm * arm * spin * dt).epsilon(1e-6));
}

TEST_CASE("spin of a face on a face meets no more than mu N times the radius of gyration, and takes it") {
  const Model model = hull_model(0.3);
  State s = two_cubes(0.01);
  ready(model, s);
  s.grains.motion[1].spin = Vec3(1e4, 0, 0);
  const double arm = arm_of(0.01), normal = 0.01 * modulus, most = 0.3 * normal;
  const Pass first = pass(model, s), second = pass(model, s);
  CHECK(first.b.torque.x() == Approx(-arm * most).epsilon(1e-9));
  CHECK(second.energy.friction == Approx(arm * most * 1e4 * dt).epsilon(1e-9));  // all of it is plastic by now
}

TEST_CASE("deep in each other the arm of spin is the body's radius at most") {
  // A slightly tapered rod through a plate: a ring of faces, whose areas all but cancel.
  std::vector<Vec3> corners;
  for (const double z : {-1.0, 1.0})
    for (const double x : {-1.0, 1.0})
      for (const double y : {-1.0, 1.0}) corners.emplace_back((0.5 - 0.005 * z) * x, (0.5 - 0.005 * z) * y, z);
  const auto torque = [&](double friction) {
    const Model model = hull_model(friction);
    State s;
    add_body(s, hull_of(corners), Vec3::Zero(), Quat::Identity());
    add_body(s, box_between(Vec3(-2, -2, -0.25), Vec3(2, 2, 0.25)), Vec3(0, 0, 0.1), Quat::Identity());
    ready(model, s);
    s.grains.motion[1].spin = Vec3(0, 0, 1e9);
    const Pass p = pass(model, s);
    const double normal = p.touch.overlap * p.contact.stiffness;
    if (friction > 0) CHECK(p.contact.stiffness / modulus < 0.02);  // of the ring's two square metres
    return std::pair{p.b.torque, normal};
  };
  const auto [with, normal] = torque(0.3);
  const Vec3 without = torque(0).first;
  const double radius = std::sqrt(1 + 2 * 0.505 * 0.505);
  CHECK((with - without).norm() < 1.01 * radius * 0.3 * normal);
  CHECK((with - without).norm() > 0.98 * radius * 0.3 * normal);  // the origin is not quite the middle of the rod
}

namespace {

constexpr double side = 2.1, pressed = 1e-3;  // of the cell across; of a layer in the next (m)

/// Two layers of four unit cubes in a cell that shears along x at `speed` (m/s) of its upper end, the upper layer by so
/// much aside.
State layers(const Model& model, double aside, double speed) {
  State s;
  for (int layer = 0; layer < 2; ++layer)
    for (const double x : {0.5, 0.5 + 0.5 * side})
      for (const double y : {0.5, 0.5 + 0.5 * side})
        add_body(s, unit_cube(), Vec3(x + layer * aside, y, 0.5 + (1 - pressed) * layer), Quat::Identity());
  s.boundary.cell.vectors = Vec3(side, side, 2 * (1 - pressed)).asDiagonal();
  ready(model, s);
  Mat3 rate = Mat3::Zero();
  rate(0, 2) = speed;
  set_cell_rate(s, rate);
  return s;
}

}  // namespace

TEST_CASE("layers of bricks in bond slide as the cell shears, and the cell works mu N times the way of its upper end") {
  constexpr double mu = 0.3, speed = 0.2, way = 0.1;
  Model model = hull_model(mu);
  model.numerics.time_step = 1e-4;
  State s = layers(model, 0.3, speed);
  for (Inertia& i : s.grains.inertia) i.moments *= 1e9;  // friction above and below turns none of them
  Team team(1);
  run_for(model, s, way / speed, team);
  // Each joint slides by half of it, less what its spring gives way; of both layers' length the joints of both are
  // bare.
  const double normal = modulus * pressed * 2 * (side - 4 * (0.5 * side - 1)), spring = mu * pressed / 0.5;
  CHECK(s.ledger.work == Approx(mu * normal * (way - spring)).epsilon(2e-3));
  CHECK(s.ledger.friction == Approx(mu * normal * (way - 2 * spring)).epsilon(2e-3));
  const Measurement m = measure(model, s);
  CHECK(-m.stress(2, 2) * side * side == Approx(normal).epsilon(1e-3));
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-3);
}

TEST_CASE(
    "columns of cubes that nothing holds turn with the shear: no joint slides, and the cell gets back the pressure") {
  constexpr double mu = 0.3, speed = 0.5;
  Model model = hull_model(mu);
  model.numerics.time_step = 1e-4;
  State s = layers(model, 0, speed);
  const double height = 2 * (1 - pressed), first = 8 * 0.5 * modulus * pressed * pressed;
  Team team(1);
  for (const double way : {0.02, 0.04, 0.06, 0.12}) {
    run_for(model, s, way / speed - s.time, team);
    // A column of whole cubes, turned, is as long as before; the cell's edge along it grows.
    const double left = std::max(0.0, 1 - 0.5 * std::hypot(height, way));
    const double held = measure(model, s).elastic;
    CAPTURE(way);
    CHECK(held == Approx(first * std::pow(left / pressed, 2)).epsilon(0.02).margin(1e-12));
    CHECK(s.ledger.work == Approx(held - first + kinetic_energy(s.grains) + s.ledger.friction).margin(2e-3 * first));
    CHECK(s.ledger.friction < 2e-3 * mu * modulus * pressed * 4 * way);
  }
}
