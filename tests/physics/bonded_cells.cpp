// SPDX-License-Identifier: LGPL-3.0-or-later
// Cells bonded by their faces: the patch, moduli of networks, impacts, breaks that go over into contacts, periodic
// cells.
#include "dem/bond/dashpots.hpp"
#include "dem/io/archive.hpp"
#include "dem/motion/critical_step.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/linear_response.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/rve.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/bonded.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// A periodic cube of cells of about unit size.
State periodic_cells(const Model& model, std::size_t count, int relax, std::uint64_t seed, Team& team) {
  State s;
  const double side = std::cbrt(static_cast<double>(count));
  s.boundary.cell.vectors = side * Mat3::Identity();
  add_voronoi_grains(model, voronoi_packing(periodic_space(Vec3::Constant(side)), count, relax, seed, team), 0, s);
  return s;
}

struct Moduli {
  double youngs, poisson;
};

/// Of the isotropic part of a tangent.
Moduli moduli_of(const Mat6& c) {
  const double bulk = c.topLeftCorner<3, 3>().sum() / 9;
  double shear = (c.topLeftCorner<3, 3>().trace() - c.topLeftCorner<3, 3>().sum() / 3) / 10;
  shear += c.bottomRightCorner<3, 3>().trace() / 5;
  return {9 * bulk * shear / (3 * bulk + shear), (3 * bulk - 2 * shear) / (6 * bulk + 2 * shear)};
}

}  // namespace

TEST_CASE("the patch: with shear as stiff as tension any cells have E = E0 and no lateral strain, exactly") {
  Team team(2);
  const Model model = rock(elastic(1));
  for (const std::uint64_t seed : {1u, 2u}) {
    State s = periodic_cells(model, 216, seed == 1 ? 5 : 0, seed, team);
    const Mat6 c = network_tangent(model, s);
    const Mat6 compliance = c.inverse();
    for (int k = 0; k < 3; ++k) {
      CHECK(1 / compliance(k, k) == Approx(E0).epsilon(1e-6));
      CHECK(std::abs(compliance(k, (k + 1) % 3)) * E0 < 1e-6);
    }
  }
}

TEST_CASE("networks of 512 relaxed cells have the moduli that an independent assembly found") {
  Team team(2);
  struct Row {
    double ratio, youngs, poisson;
  };
  for (const Row& row : {Row{0.7, 0.8703, 0.0649}, Row{0.4, 0.7150, 0.1425}, Row{0.1, 0.5114, 0.2443}}) {
    const Model model = rock(elastic(row.ratio));
    State s = periodic_cells(model, 512, 5, 1, team);
    const Moduli m = moduli_of(network_tangent(model, s));
    CHECK(m.youngs / E0 == Approx(row.youngs).epsilon(0.015));
    CHECK(m.poisson == Approx(row.poisson).margin(0.005));
  }
}

TEST_CASE("a bonded cell that vibrates keeps its energy; pairs that bonds hold are no contacts") {
  Team team(2);
  Model model = rock(elastic(0.4));
  model.numerics.safety = 0.05;  // leapfrog shows up to (w dt)^2 / 8 more or less
  State s = periodic_cells(model, 125, 5, 1, team);
  for (std::size_t i = 0; i < s.grains.size(); ++i)
    for (int k = 0; k < 3; ++k)
      s.grains.motion[i].velocity[k] = random_normal(8, i, Purpose::turn, static_cast<std::uint64_t>(k));
  prepare(model, s, team);
  const double before = stored_energy(model, s);
  run_steps(model, s, 2000, team);
  CHECK(stored_energy(model, s) == Approx(before).epsilon(1e-3));
  CHECK(stored_energy(s.bonds) > 0.3 * before);
  for (std::size_t k = 0; k < s.contacts.size(); ++k) CHECK(s.contacts.touch[k].force.norm() < 1e-3 * E0);
}

namespace {

/// A bar of cells whose ends run at each other: it crushes within some microseconds.
State crushed_bar(const Model& model, Team& team, double speed) {
  State s;
  add_voronoi_grains(model, voronoi_packing(box_space(Vec3(30e-3, 6e-3, 6e-3)), 240, 5, 1, team), 0, s);
  for (Motion& m : s.grains.motion) m.velocity.x() = -speed * (m.position.x() - 15e-3) / 15e-3;
  prepare(model, s, team);
  return s;
}

}  // namespace

TEST_CASE("half of all bonds break in an impact: energy is told, momentum stays, threads give the same bits") {
  BondModel b = cohesive(6e6, 15);
  b.stiffness = 28e9;
  for (const double friction : {0.0, 0.5}) {
    b.friction = friction, b.damping = 0.2 * friction;
    Model model = rock(b, friction);
    model.materials[0].contact = Foundation::Of{.modulus = b.stiffness, .shear_ratio = b.ratio};
    make_pair_laws(model);
    const auto run = [&](int threads) {
      Team team(threads);
      State s = crushed_bar(model, team, 20);
      const double start = kinetic_energy(s.grains);
      const Vec3 p = momentum(s.grains), l = angular_momentum(s.grains);
      const std::size_t bonds = s.bonds.size();
      run_for(model, s, 20e-6, team);
      CHECK(10 * s.bonds.size() < 7 * bonds);
      CHECK(s.ledger.bonds_broken == bonds - s.bonds.size());
      const double told = stored_energy(model, s) + s.ledger.fracture + s.ledger.friction + s.ledger.damping;
      CHECK(told == Approx(start).epsilon(0.01));
      CHECK(s.ledger.fracture > 0.1 * start);
      CHECK((momentum(s.grains) - p).norm() < 1e-12);
      CHECK((angular_momentum(s.grains) - l).norm() < 1e-13);
      return s;
    };
    const State one = run(1), two = run(2);
    for (std::size_t i = 0; i < one.grains.size(); ++i)
      REQUIRE(one.grains.motion[i].position == two.grains.motion[i].position);
    CHECK(hash(one) == hash(two));
    for (std::size_t k = 0; k < one.bonds.dashpot.size(); ++k) {  // each is still that of its own bond
      const FaceDashpot own = dashpot_of(one.bonds.face.row[k], one.grains, b.damping);
      CHECK(one.bonds.dashpot[k].normal == Approx(own.normal).epsilon(1e-9));
    }
    CHECK(one.bonds.dashpot.size() == (friction > 0 ? one.bonds.face.row.size() : 0));
    CHECK((one.ledger.bond_damping > 0.01 * one.ledger.fracture) == (friction > 0));
    CHECK(hash(state_of(bytes_of(one))) == hash(one));
    const Fragments fragments = fragments_of(one);
    CHECK(fragments.size.size() > 5);
    std::size_t cells = 0;
    for (const std::size_t n : fragments.size) cells += n;
    CHECK(cells == one.grains.size());
  }
}

TEST_CASE("a run goes on from its bytes with the same bits, broken bonds and all") {
  BondModel b = cohesive(6e6, 15);
  b.stiffness = 28e9, b.friction = 0.3;
  Model model = rock(b, 0.3);
  Team team(1);
  State s = crushed_bar(model, team, 20);
  for (int k = 0; k < 400; ++k) {
    run_steps(model, s, 1, team);
    if (!s.bonds.handed.empty()) break;  // between a break and the list that takes it over
  }
  REQUIRE(!s.bonds.handed.empty());
  // Faces that soften, whose outlines are not in the bytes, and what has given way of them slides and twists.
  const auto& rows = s.bonds.face.row;
  REQUIRE(std::count_if(rows.begin(), rows.end(), [](const FaceBond& f) { return f.slip_3 != 0 && f.rubbed > 0; }) > 3);
  REQUIRE(!s.bonds.outline.corner.empty());
  State again = state_of(bytes_of(s));
  for (State* state : {&s, &again}) run_steps(model, *state, 100, team);
  CHECK(hash(s) == hash(again));
}

TEST_CASE("a bond that breaks under pressure goes over into a contact without a step in the force") {
  BondModel b = cohesive(1e6, 16e3);
  b.friction = 0.4;
  Model model = rock(b, 0.4);
  model.numerics.time_step = 2e-6;
  Team team(1);
  Tessellation cells;
  cells.seed = {Vec3(0.5, 0.5, 0.5), Vec3(1.5, 0.5, 0.5)};
  for (int k = 0; k < 2; ++k) cells.body.push_back(box_between(Vec3(k, 0, 0), Vec3(k + 1, 1, 1)));
  cells.body[0].face[1].tag = 0, cells.body[1].face[0].tag = 0;
  cells.partner = {{{1, {}}}, {{0, {}}}};
  State s;
  add_voronoi_grains(model, cells, 0, s);
  REQUIRE(s.bonds.size() == 1);
  // Held at both ends: heavy, pressed by 2 mm, sheared at constant speed.
  for (std::size_t i = 0; i < 2; ++i)
    s.grains.mass[i] *= 1e9, s.grains.motion[i].inverse_mass /= 1e9, s.grains.inertia[i].moments *= 1e9;
  s.grains.motion[1].position.x() -= 2e-3;
  s.grains.motion[1].velocity.y() = 2;
  prepare(model, s, team);
  Vec3 last = Vec3::Zero();
  bool went_over = false;
  double before = 0, after = 0;
  for (int k = 0; k < 60000 && s.time < 0.12; ++k) {
    run_steps(model, s, 1, team);
    Vec3 force = Vec3::Zero();
    for (const FaceBond& bond : s.bonds.face.row) force += bond.force;
    for (std::size_t c = 0; c < s.contacts.size(); ++c) force += s.contacts.touch[c].force;
    if (s.bonds.empty() && !went_over) {
      before = last.norm();
      run_steps(model, s, 2, team);
      force = Vec3::Zero();
      for (std::size_t c = 0; c < s.contacts.size(); ++c) force += s.contacts.touch[c].force;
      after = force.norm(), went_over = true;
      CHECK(std::abs(force.y() / last.y() - 1) < 0.035);
      break;
    }
    last = force;
  }
  REQUIRE(went_over);
  CHECK(after / before ==
        Approx(1).epsilon(0.035));  // b has slid by a thirtieth of its face: there is so much less of it
}

TEST_CASE("a periodic cell that is strained does the work that its bonds hold, and answers with its modulus") {
  Team team(2);
  Model model = rock(elastic(1));
  set_damping(model, 0.3);
  State s = periodic_cells(model, 64, 5, 1, team);
  prepare(model, s, team);
  Mat3 rate = Mat3::Zero();
  rate(2, 2) = -0.002;
  set_cell_rate(s, rate * s.boundary.cell.vectors);
  run_for(model, s, 1, team);
  const double strain = 0.002, volume = 64;
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-3);
  CHECK(s.ledger.work == Approx(0.5 * E0 * strain * strain * volume).epsilon(0.02));
  CHECK(love_weber(s, volume)(2, 2) == Approx(-E0 * strain).epsilon(0.02));
}

namespace {

/// Two unit cubes that share a face across x = 1.
State two_cubes(const Model& model) {
  Tessellation cells;
  for (const std::size_t k : {0u, 1u}) {
    const Vec3 low(static_cast<double>(k), 0, 0);
    cells.body.push_back(box_between(low, low + Vec3::Ones()));
    cells.body[k].face[1 - k].tag = 0;
    cells.seed.emplace_back(low + Vec3::Constant(0.5));
    cells.partner.push_back({{static_cast<Index>(1 - k), {}}});
  }
  State s;
  add_voronoi_grains(model, cells, 0, s);
  return s;
}

}  // namespace

TEST_CASE(
    "an RVE of bonded cells that nothing has loaded is drawn as it is pressed; what would take for ever says so") {
  Team team(1);
  auto model = std::make_shared<Model>(rock(elastic(1)));
  set_damping(*model, 0.3);
  State s = periodic_cells(*model, 64, 5, 1, team);
  prepare(*model, s, team);
  QuasiStatic o;
  o.unbalanced_force = o.stress_change = 1e-3;
  double stress[2];
  for (const double sign : {-1.0, 1.0}) {
    Rve rve(model, o, s);
    State room;
    Increment to;
    to.deformation(2, 2) = 1 + sign * 1e-5;
    const Response r = rve.advance(to, room);
    REQUIRE(r.stable);
    stress[sign < 0 ? 0 : 1] = r.stress(2, 2);
    CHECK(r.steps < 20000);
  }
  CHECK(stress[1] == Approx(E0 * 1e-5).epsilon(0.01));  // the patch
  CHECK(stress[1] == Approx(-stress[0]).epsilon(0.005));
  o.inertial_number = 1e-12;  // so slow that it never gets there
  Rve slow(model, o, s);
  State room;
  Increment to;
  to.deformation(2, 2) = 1 + 1e-3;
  const Response r = slow.advance(to, room);
  CHECK_FALSE(r.stable);
  CHECK(r.failure.find("pressure_floor") != std::string::npos);
}

TEST_CASE("a dashpot of zeta lets opening, twist and bending die as zeta of critical, and what it takes is told") {
  Team team(1);
  BondModel bond = elastic(0.5);
  bond.damping = 0.05;
  Model model = rock(bond);
  model.numerics.safety = 0.02;
  // Relative modes, half of whose mass or inertia moves: w^2 = 2 k / m and 2 k / J; bending without opening needs the
  // shear's lever, so it is pushed about the face's middle.
  const double mass = density, inertia = density / 6;
  struct Mode {
    Vec3 velocity, spin;
    double frequency2;
  };
  for (const Mode& mode : {Mode{Vec3(1e-3, 0, 0), Vec3::Zero(), 2 * E0 / mass},
                           Mode{Vec3::Zero(), Vec3(1e-3, 0, 0), 2 * 0.5 * E0 / 6 / inertia}}) {
    State s = two_cubes(model);
    REQUIRE(s.bonds.dashpot.size() == 1);
    s.grains.motion[1].velocity = mode.velocity, s.grains.motion[0].velocity = -mode.velocity;
    for (const std::size_t i : {0u, 1u}) {
      s.grains.motion[i].spin = (i == 1 ? 1 : -1) * mode.spin;
      s.grains.angular_momentum[i] = inertia_tensor(s.grains, i) * s.grains.motion[i].spin;
    }
    prepare(model, s, team);
    const double start = stored_energy(model, s), omega = std::sqrt(mode.frequency2);
    s.ledger.start = start;
    // Whole periods of the damped oscillation: energies compare without their ripple.
    run_for(model, s, 3 * 2 * pi / (omega * std::sqrt(1 - 0.05 * 0.05)), team);
    CHECK(std::log(start / stored_energy(model, s)) ==
          Approx(2 * 0.05 * 3 * 2 * pi / std::sqrt(1 - 0.05 * 0.05)).epsilon(5e-3));
    CHECK(s.ledger.bond_damping == Approx(start - stored_energy(model, s)).epsilon(1e-3));
    CHECK(s.ledger.bond_damping == s.ledger.damping);
    CHECK(momentum(s.grains).norm() < 1e-12 * mass * 1e-3);
  }
}

TEST_CASE("the critical step of two cells with dashpots: below what their stiffest mode bears, and near it") {
  Team team(1);
  for (const double fraction : {0.0, 0.9}) {
    BondModel bond = elastic(1);
    bond.damping = fraction;
    const Model model = rock(bond);
    State s = two_cubes(model);
    s.grains.motion[1].velocity = Vec3(1e-3, 7e-4, 3e-4);
    prepare(model, s, team);
    const double told =
        critical_step(model.law, model.pairs, model.materials.size(), s.grains, s.boundary, s.contacts, s.bonds).dt;
    // Sliding with its lever of a half, l^2 / J = 1.5 / m: both cubes turn alike, so no dashpot of turns is at work.
    const double omega = std::sqrt(5 * E0 / density), over = 5 * 2 * fraction * std::sqrt(0.5) / std::sqrt(5.0);
    const double borne = 2 / omega * 2 / (over + std::sqrt(over * over + 4));
    CAPTURE(fraction, told, borne);
    CHECK(told < borne);
    CHECK(told > 0.8 * borne);
    const auto fastest = [&](double dt) {
      State copy = s;
      Model fixed = model;
      fixed.numerics.time_step = dt, fixed.numerics.max_energy_error = INFINITY;
      prepare(fixed, copy, team);
      double most = 0;
      for (int k = 0; k < 300 && most < 1; ++k) {
        run_steps(fixed, copy, 1, team);
        most = std::max(most, copy.grains.motion[1].velocity.norm());
      }
      return most;
    };
    CHECK(fastest(told) < 3e-3);
    CHECK(fastest(1.05 * borne) > 1);
  }
}
