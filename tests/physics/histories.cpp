// SPDX-License-Identifier: LGPL-3.0-or-later
// What contacts and springs remember when bodies turn, split and cross the cell's seam; and what cells do on the way.
#include "dem/bond/cohesive.hpp"
#include "dem/contact/forces.hpp"
#include "dem/rve/breakage.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/reshape.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 3e-4;

Model sticky(bool brittle = false, double rounding = 0) {
  Material m = solid(60e9, 0.17, 2650, 10);
  m.rolling_friction = 10;
  if (brittle) {
    FractureModel f;
    f.criteria.emplace_back(HoekBrown{592e6, 20.56});
    f.springs = CohesiveSprings{4, 1.77e6};
    halves_in(f).rounding = rounding;
    m.fracture = f;
  }
  return model_of(m);
}

Vec3 spring(const State& s, std::size_t k) { return s.contacts.contact[k].spring[slide_spring]; }
Vec3 roll(const State& s, std::size_t k) { return s.contacts.contact[k].spring[roll_spring]; }

/// A cell of 64 grains in contact, sheared so that tangential springs are stretched.
State sheared(const Model& model, Team& team) {
  State s;
  for (int i = 0; i < 64; ++i)
    add(s, PolyEllipsoid::sphere(R), 1.99 * R * Vec3(i % 4, i / 4 % 4, i / 16), 2650,
        0.05 * (random_rotation(7, static_cast<std::uint64_t>(i)) * Vec3(1, 0, 0)));
  s.boundary.cell.vectors = 4 * 1.99 * R * Mat3::Identity();
  prepare(model, s, team);
  Mat3 rate = Mat3::Zero();
  rate(0, 2) = 200, rate(1, 0) = 100;
  set_cell_rate(s, rate * s.boundary.cell.vectors);
  run_steps(model, s, 60, team);
  set_cell_rate(s, Mat3::Zero());
  return s;
}

}  // namespace

TEST_CASE("a pair that turns as one body keeps its tangential spring: turned with it, as long as it was") {
  const Model model = sticky();
  Team team(1);
  for (const bool about_normal : {false, true}) {
    State s;
    for (int i : {0, 1}) add(s, PolyEllipsoid::sphere(R), Vec3(1.98 * R * i, 0, 0), 2650);
    prepare(model, s, team);
    REQUIRE(s.contacts.contact.touching(0));
    Contact c = s.contacts.contact[0];
    c.spring[slide_spring] = Vec3(0, 0.3, 0.2), c.spring[roll_spring] = Vec3(0, -0.1, 0.3);
    s.contacts.contact.set(0, c);
    const Vec3 before = c.spring[slide_spring], rolled = c.spring[roll_spring],
               axis = about_normal ? Vec3(1, 0, 0) : Vec3(0, 0.6, 0.8), centre(0.99 * R, 0, 0);
    const double step = 1e-3, dt = 1e-8;
    const int steps = 500;
    for (int k = 0; k < steps; ++k) {  // carried about by hand, half a step for the velocities
      for (auto& m : s.grains.motion) {
        const Vec3 from = m.position - centre, to = Eigen::AngleAxisd(step, axis) * from;
        m.position = centre + to, m.velocity = (to - from) / dt, m.spin = step / dt * axis;
      }
      contact_forces(model.law, model.pairs, s.grains, s.boundary, dt, true, s.contacts, team);
      drop_loads(s.contacts);
    }
    const Vec3 turned = Eigen::AngleAxisd(step * steps, axis) * before;
    // Slip of a turning pair is of the third order of the step's angle; the spring turns by chords.
    CHECK((spring(s, 0) - turned).norm() < 2e-3 * before.norm());
    CHECK(spring(s, 0).norm() == Approx(before.norm()).epsilon(2e-3));
    CHECK((roll(s, 0) - Eigen::AngleAxisd(step * steps, axis) * rolled).norm() < 2e-3 * rolled.norm());
  }
  // The plain form, for poly-ellipsoids at walls: a turn of 0.1 rad in one step is not a loss.
  PairLaw law;
  law.own = HertzMindlin::Pair{30e9}, law.shear_ratio = 0.8, law.friction = {10};
  Contact c;
  c.stiffness = 1e9, c.radius = R, c.compliance = 1 / (0.8 * 1.5 * 1e9 * std::sqrt(1e-6)),
  c.spring[slide_spring] = Vec3(0.3, 0.4, 0);
  Touch touch;
  BlockEnergy e;
  const Vec3 tilted = Eigen::AngleAxisd(0.1, Vec3(0, 1, 0)) * Vec3(0, 0, 1);
  advance_contact(HertzMindlin{}, law, 1, c, touch, tilted, 1e-6, Vec3::Zero(), 0, 1e-7, e);
  CHECK(c.spring[slide_spring].norm() == Approx(0.5).epsilon(1e-9));
  CHECK(std::abs(c.spring[slide_spring].dot(tilted)) < 1e-12);
  c.spring[slide_spring] = Vec3(0.5, 0, 0);
  advance_contact(HertzMindlin{}, law, 1, c, touch, Vec3(0, 0, 1), 1e-6, Vec3::Zero(), 1e5, 1e-7,
                  e);  // the pair twists by 0.01
  CHECK(c.spring[slide_spring].y() == Approx(0.5 * 0.01).epsilon(1e-3));
}

TEST_CASE("a state that is turned answers to a turned shear as it would have, turned: tangential springs included") {
  const Model model = sticky();
  Team team(1);
  State here = sheared(model, team), there = here;
  double tangential = 0, normal = 0, rolling = 0;
  for (std::size_t k = 0; k < here.contacts.size(); ++k)
    tangential += spring(here, k).norm(), normal += here.contacts.touch[k].force.norm();
  REQUIRE(tangential > 0.05 * normal);
  const Mat3 turn = random_rotation(9, 2).toRotationMatrix();
  rotate(there, turn);
  Mat3 rate = Mat3::Zero();
  rate(0, 2) = 150, rate(1, 1) = -80;
  set_cell_rate(here, rate * here.boundary.cell.vectors);
  set_cell_rate(there, turn * rate * turn.transpose() * there.boundary.cell.vectors);
  run_steps(model, here, 5, team), run_steps(model, there, 5, team);
  for (std::size_t k = 0; k < here.contacts.size(); ++k) {
    REQUIRE((turn * spring(here, k) - spring(there, k)).norm() < 1e-9 * normal / 64);
    REQUIRE((turn * roll(here, k) - roll(there, k)).norm() < 1e-9 * normal / 64);
    rolling += roll(here, k).norm();
  }
  REQUIRE(rolling > 1e-4 * normal);
  const Mat3 a = love_weber(here, 1), b = love_weber(there, 1);
  CHECK((turn * a * turn.transpose() - b).norm() < 1e-10 * a.norm());
}

TEST_CASE("a state that is turned turns the forces that its bonds hold, between two steps") {
  State s;
  for (int i : {0, 1}) add(s, PolyEllipsoid::sphere(R), Vec3(1.98 * R * i, 0, 0), 2650);
  CohesiveSpring held{};
  held.ends = {0, 1, {}}, held.force = Vec3(1, 2, 3);
  s.bonds.cohesive.row.push_back(held);
  FaceBond face{};
  face.ends = {0, 1, {}}, face.force = Vec3(3, -1, 2), face.shear = Vec3(0, 5, 1);
  s.bonds.face.row.push_back(face);
  FaceDashpot dashpot;
  dashpot.force = Vec3(1, 0, 2), dashpot.couple = Vec3(0, 4, 1);
  s.bonds.dashpot.push_back(dashpot);
  Handed handed{};
  handed.shear = Vec3(7, 1, 0);
  s.bonds.handed.push_back(handed);
  const Mat3 stress = love_weber(s, 1), turn = random_rotation(9, 4).toRotationMatrix();
  rotate(s, turn);
  const auto turned = [&](const Vec3& now, const Vec3& before) { CHECK((now - turn * before).norm() < 1e-14); };
  turned(s.bonds.cohesive.row[0].force, held.force);
  turned(s.bonds.face.row[0].force, face.force), turned(s.bonds.face.row[0].shear, face.shear);
  turned(s.bonds.dashpot[0].force, dashpot.force), turned(s.bonds.dashpot[0].couple, dashpot.couple);
  turned(s.bonds.handed[0].shear, handed.shear);
  CHECK((love_weber(s, 1) - turn * stress * turn.transpose()).norm() < 1e-14 * stress.norm());
}

TEST_CASE("a jump of the cell's rate gives and takes the grains' kinetic energy, to the last joule") {
  const Model model = sticky();
  Team team(1);
  State s = sheared(model, team);
  const double before = kinetic_energy(s.grains), work = s.ledger.work;
  Mat3 rate = Mat3::Zero();
  rate.diagonal() = Vec3(3000, -2000, 1000);
  set_cell_rate(s, rate * s.boundary.cell.vectors);
  const double gained = kinetic_energy(s.grains) - before;
  REQUIRE(std::abs(gained) > before);
  CHECK(s.ledger.work - work == Approx(gained).epsilon(1e-12));
}

TEST_CASE("halves inherit tangential springs, whichever side of the pair the parent was, and across the seam") {
  const Model model = sticky(true);
  Team team(1);
  for (const int position :
       {0, 1, 2})  // of the parent among the three: its neighbours come after it, before it, on both sides
    for (const bool seam : {false, true}) {
      INFO("parent " << position << " seam " << seam);
      State s;
      const double pitch = 1.98 * R;
      std::vector<double> at{0, -pitch, pitch};
      std::swap(at[0], at[static_cast<std::size_t>(position)]);
      const double edge = seam ? 3 * pitch : 20 * R;  // with a seam what is before the parent is beyond it
      for (const double x : at)
        add(s, PolyEllipsoid::sphere(R), Vec3(x < 0 && seam ? x + edge : x, 5 * R, 5 * R), 2650);
      s.boundary.cell.vectors = Vec3(edge, 20 * R, 20 * R).asDiagonal();
      prepare(model, s, team);
      const auto parent = static_cast<std::size_t>(position);
      std::size_t set = 0;
      for (std::size_t k = 0; k < s.contacts.size(); ++k) {
        const Pair& p = s.contacts.pair[k];
        if (!s.contacts.contact.touching(k) || (p.a != parent && p.b != parent)) continue;
        Contact c = s.contacts.contact[k];
        c.spring[slide_spring] = (p.b == parent ? 1 : -1) * Vec3(0, 0.03, 0.01), ++set;  // the force on the parent
        c.spring[roll_spring] = (p.b == parent ? 1 : -1) * Vec3(0, -0.01, 0.02);         // the couple on it
        s.contacts.contact.set(k, c);
      }
      REQUIRE(set == 2);
      apply_breaks(model, s, {across(s, parent, 1)}, team);  // across y: both halves touch both neighbours, and share
      Vec3 on_halves = Vec3::Zero(), couple = Vec3::Zero();
      for (std::size_t k = 0; k < s.contacts.size(); ++k) {
        const Pair& p = s.contacts.pair[k];
        const bool half_a = p.a == parent || p.a == 3, half_b = p.b == parent || p.b == 3;
        if (!s.contacts.contact.touching(k) || half_a == half_b) continue;
        on_halves += (half_b ? 1 : -1) * spring(s, k), couple += (half_b ? 1 : -1) * roll(s, k);
      }
      // The edge's rounding takes a part of each half's overlap, and with it of its stiffness: never all, and never the
      // direction.
      CHECK(on_halves.norm() > 0.5 * 2 * Vec3(0, 0.03, 0.01).norm());
      CHECK(on_halves.norm() < 1.01 * 2 * Vec3(0, 0.03, 0.01).norm());
      CHECK(on_halves.normalized().dot(Vec3(0, 0.03, 0.01).normalized()) > 0.99);
      CHECK(couple.norm() / on_halves.norm() == Approx(std::sqrt(0.5)).epsilon(0.01));  // shared as springs are
      CHECK(couple.normalized().dot(Vec3(0, -0.01, 0.02).normalized()) > 0.99);
    }
}

TEST_CASE("halves on springs: a spinning pair keeps its angular momentum, and its stress is that of its own inertia") {
  const Model model = sticky(true, 0.02);
  Team team(1);
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650, Vec3(1, 0, 0), Vec3(500, 3000, -800));
  prepare(model, s, team);
  apply_breaks(model, s, {across(s, 0, 0)}, team);
  REQUIRE(s.bonds.size() == 4);
  double virial = 0;
  for (std::size_t i = 0; i < 2; ++i) virial -= s.grains.force[i].dot(s.grains.motion[i].position);
  REQUIRE(virial > 0);  // the springs pull the halves in
  CHECK(love_weber(s, 1).trace() == Approx(virial).epsilon(1e-9));
  const Vec3 l = angular_momentum(s.grains), p = momentum(s.grains);
  const double scale = l.norm();
  for (auto& spring : s.bonds.cohesive.row)
    spring.preload += 0.2 * spring.onset * Vec3(0, 0.5, 1);  // so that they pull askew
  for (int k = 0; k < 300; ++k) run_steps(model, s, 1, team);
  REQUIRE(s.bonds.size() == 4);
  CHECK((momentum(s.grains) - p).norm() < 1e-12 * p.norm());
  CHECK((angular_momentum(s.grains) - l).norm() < 1e-11 * scale);
}

TEST_CASE("a surface that grows against fixed neighbours puts in exactly what the contacts then hold more") {
  const Model model = growing(2e-5);
  Team team(1);
  State s;
  PolyEllipsoid bad = PolyEllipsoid::sphere(R);
  bad.minus.x() = 0.1 * R;
  add(s, bad, Vec3::Zero(), 2650);
  update_frames(s.grains);
  for (const double side : {-1.0, 1.0}) {
    Wall wall;
    wall.material = 1, wall.shape = PlaneWall{Vec3(-side, 0, 0)},
    wall.point = surface_arm(s.grains, 0, side * Vec3::UnitX()) - Vec3(0.01 * side * R, 0, 0);
    s.boundary.walls.push_back(wall);
  }
  prepare(model, s, team);
  s.grains.generation[0] = 1;
  Reshaping reshaping;
  const double before = elastic_energy(model.law, s.contacts);
  for (int k = 0; k < 50; ++k) {
    reshape_fragments(model, s, 2e-9, reshaping, team);
    contact_forces(model.law, model.pairs, s.grains, s.boundary, 0, true, s.contacts, team);
    drop_loads(s.contacts);
    book_growth(model, s, reshaping);
  }
  const double gained = elastic_energy(model.law, s.contacts) - before;
  REQUIRE(std::abs(gained) > 1e-3 * before);
  CHECK(s.ledger.reshape == Approx(gained).epsilon(1e-3));  // fifty trapezoids
  // Lists count what has grown: on both sides of a gap, more than half of the skin may have been closed unseen.
  CHECK(s.reference.grown >= s.grains.shape[0].minus.x() - bad.minus.x());
  for (const double part : {0.45, 0.55}) {
    s.reference.grown = part * s.reference.skin;
    CHECK((look_at_list(s.grains, s.boundary, s.reference) == ListState::holds) == (part < 0.5));
  }
}

TEST_CASE("a hold waits for the stress too, and a strain is taken in steps of no more than asked") {
  Model model = sticky();
  set_damping(model, 0.05);
  Team team(1);
  State start = sheared(model, team);
  QuasiStatic q;
  q.unbalanced_force = 1e9, q.pressure_floor = 0, q.window = 10;
  std::uint64_t before = 0;
  double asked = 1;
  for (int round = 0; round < 3; ++round) {
    State s = start;
    q.stress_change = asked;
    const Response r = hold(model, q, s, team);
    REQUIRE(r.stable);
    CHECK(r.stress_change <= asked);
    CHECK(r.hold_steps > before);
    before = r.hold_steps, asked = 0.02 * r.stress_change;
  }
  q.stress_change = 1e9, q.inertial_number = 1e9;
  Increment squeeze;
  squeeze.deformation(2, 2) -= 1e-3;
  for (const double per_step : {1e-4, 1e-5}) {
    State s = start;
    q.strain_per_step = per_step;
    const Response r = deform(model, q, s, squeeze, team);
    CHECK(static_cast<double>(r.steps - r.hold_steps) == Approx(1e-3 / per_step).epsilon(0.3).margin(2));
  }
}

TEST_CASE("a servo closes the gap to its stress over the two hundred steps that it promises") {
  Model model = linear_model(1e6, 0.8, 2650, 1e3);
  set_damping(model, 0.5);
  State s;
  const double pitch = 2 * R * (1 - 1e-3);
  for (int i = 0; i < 64; ++i) add(s, PolyEllipsoid::sphere(R), pitch * Vec3(i % 4, i / 4 % 4, i / 16), 2650);
  s.boundary.cell.vectors = 4 * pitch * Mat3::Identity();
  Team team(1);
  prepare(model, s, team);
  const double start = measure(model, s).stress(2, 2), asked = 1.2 * start;
  Loading loading;
  loading.driven = true;
  loading.axes[2] = {0, asked, 1e9};
  begin_loading(model, s, loading);
  load(model, s, loading, s.time + 400 * s.dt, team);
  // Corrected every 25 steps by 25 / 200 of the gap: (7 / 8)^16 = 0.12 of it is left, and the lattice swings a little.
  const double left = (asked - measure(model, s).stress(2, 2)) / (asked - start);
  CHECK(left < 0.3);
  CHECK(left > -0.1);
  load(model, s, loading, s.time + 1600 * s.dt, team);
  CHECK(measure(model, s).stress(2, 2) == Approx(asked).epsilon(5e-3));
}
