// SPDX-License-Identifier: LGPL-3.0-or-later
// Cells whose faces bend and break: pairs joined by two faces, a beam, all faces at once.
#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "dem/rve/check_state.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/bonded.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// Eight unit cubes in a periodic cube: each pair is joined by two faces, on one side and on the other.
State eight_cubes(const Model& model) {
  Tessellation cells;
  for (std::size_t i = 0; i < 8; ++i) {
    const Vec3 low(static_cast<double>(i & 1), static_cast<double>(i >> 1 & 1), static_cast<double>(i >> 2 & 1));
    cells.body.push_back(box_between(low, low + Vec3::Ones()));
    cells.seed.emplace_back(low + Vec3::Constant(0.5));
    cells.partner.emplace_back();
    for (std::size_t k = 0; k < 6; ++k) {  // -x, +x, -y ...
      const std::size_t axis = k / 2, high = k % 2;
      Tessellation::Partner p{static_cast<Index>(i ^ (std::size_t{1} << axis)), {}};
      if ((i >> axis & 1) == high) p.image[axis] = static_cast<std::int16_t>(high ? 1 : -1);
      cells.body[i].face[k].tag = static_cast<std::int64_t>(k);
      cells.partner[i].push_back(p);
    }
  }
  State s;
  s.boundary.cell.vectors = 2 * Mat3::Identity();
  add_voronoi_grains(model, cells, 0, s);
  return s;
}

/// Strains the cell along x at a constant rate, and tells the stress there (Pa, tension positive).
double strained(const Model& model, State& s, double strain, double duration, Team& team) {
  Mat3 rate = Mat3::Zero();
  rate(0, 0) = 2 * strain / duration;
  set_cell_rate(s, rate);
  run_for(model, s, duration, team);
  set_cell_rate(s, Mat3::Zero());
  run_for(model, s, 0.3, team);
  return love_weber(s, s.boundary.cell.volume())(0, 0);
}

/// G A of all that has broken, and what the rest has spent, against what is told.
void check_fracture(const State& s, double toughness) {
  double broken = 0, area = 0, rest = 0;
  for (const BrokenBond& b : s.bonds.broken) {
    CHECK(b.energy == Approx(toughness * b.area).epsilon(0.01));
    broken += b.energy, area += b.area;
  }
  for (const FaceBond& b : s.bonds.face.row) rest += b.spent;
  CHECK(s.ledger.fracture == Approx(broken + rest).epsilon(1e-9));
  CHECK(broken == Approx(toughness * area).epsilon(0.01));
  CHECK(s.ledger.fracture_area == Approx(area).epsilon(1e-9));
}

BondModel tough_rock(double toughness) {
  BondModel b = cohesive(6e6, toughness);
  b.stiffness = 28e9, b.energy_2 = b.energy_1, b.friction = 0.3;
  b.tan_phi = 0;  // what pressure strengthens may hold more than G A, and then takes all of it
  return b;
}

Model recorded(const BondModel& b) {
  Model model = rock(b, 0.3);
  model.materials[0].contact = Foundation::Of{.modulus = b.stiffness, .shear_ratio = b.ratio};
  make_pair_laws(model);
  model.records_bonds = true;
  return model;
}

}  // namespace

TEST_CASE("cells joined by two faces: one breaks and takes G A, closes as stiff as it was, and the other holds on") {
  BondModel b = cohesive(1e6, 4e3);
  b.friction = 0.3;
  Model model = rock(b, 0.3);
  model.records_bonds = true;
  set_damping(model, 0.3);
  Team team(1);
  State s = eight_cubes(model);
  REQUIRE(s.bonds.size() == 24);
  for (FaceBond& f : s.bonds.face.row)
    if (f.ends.image[0] != 0) f.tension *= 0.8;
  prepare(model, s, team);
  CHECK(strained(model, s, 3e-4, 0.5, team) == Approx(3e-4 * E0).epsilon(0.01));
  const double open = strained(model, s, 7e-3 - 3e-4, 2, team);
  CHECK(std::abs(open) < 0.01 * 1e6);
  CHECK(s.bonds.size() == 20);
  CHECK(s.ledger.fracture == Approx(4 * 4e3).epsilon(0.01));
  check_fracture(s, 4e3);
  for (const FaceBond& f : s.bonds.face.row) CHECK(f.ends.image[0] == 0);
  CHECK(strained(model, s, -9e-3, 2, team) == Approx(-2e-3 * E0).epsilon(0.01));
  CHECK(std::abs(strained(model, s, 5e-3, 2, team)) < 0.01 * 1e6);
  CHECK(s.bonds.size() == 20);
  CHECK(s.ledger.handed >= 0);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 5e-3);
}

TEST_CASE("a beam of twenty cells is bent until it breaks: fracture never falls, and is G of the broken area") {
  Model model = recorded(tough_rock(60));  // none too coarse for its energy
  set_damping(model, 0.3);
  Team team(1);
  for (const std::uint64_t seed : {1u, 2u}) {
    State s;
    const double length = 50e-3, side = 10e-3;
    const BondedFaces faces =
        add_voronoi_grains(model, voronoi_packing(box_space(Vec3(length, side, side)), 20, 5, seed, team), 0, s);
    for (const double end : {0.0, 1.0}) {  // neither end turns, and one goes down
      Wall wall;
      wall.point = Vec3(end * length, 0, 0), wall.shape = PlaneWall{(1 - 2 * end) * Vec3::UnitX()}, wall.material = 1;
      wall.velocity = -0.4 * end * Vec3::UnitZ();
      s.boundary.walls.push_back(wall);
      double offset;
      glue(model, faces_towards(faces.outer, -wall.facing(), offset), static_cast<Index>(end), false, s);
    }
    REQUIRE(s.bonds.wall.size() >= 2);
    prepare(model, s, team);
    double before = 0;
    for (int k = 0; k < 200; ++k) {
      run_for(model, s, 1e-5, team);
      CHECK(s.ledger.fracture >= before);
      before = s.ledger.fracture;
    }
    CHECK(fragments_of(s).size.size() >= 2);
    check_fracture(s, 60);
    CHECK(s.ledger.fracture_area > 0.9 * side * side);
    CHECK(s.ledger.handed >= 0);
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.01);
  }
}

TEST_CASE("hand-over: what no contact goes on holding is told as handed, what a contact makes as unexplained") {
  Model model = recorded(tough_rock(15));
  Team team(1);
  State s;
  add_voronoi_grains(model, voronoi_packing(box_space(Vec3(12e-3, 6e-3, 6e-3)), 8, 5, 1, team), 0, s);
  prepare(model, s, team);
  const FaceBond f = s.bonds.face.row.front();
  const auto booked = [&](double apart, double held) {  // along the normal (m), J
    State copy = s;
    copy.grains.motion[f.ends.b].position += apart * (s.grains.orientation[f.ends.a] * f.normal);
    copy.bonds.handed.push_back({f.ends, f.at_a, f.kn, f.area, f.area, Vec3::Zero(), 1 / (f.kt * f.area), held, 0, 0});
    book_broken(copy, false);
    CHECK(copy.ledger.handed + copy.ledger.unexplained == Approx(held - copy.bonds.handed.back().kept));
    return copy.ledger;
  };
  CHECK(booked(1e-6, 3e-6).handed == Approx(3e-6));
  CHECK(booked(1e-6, 3e-6).unexplained == 0);
  // Two flat sides pressed by a depth: half of k_n A depth^2, as the bond has it.
  const double depth = 1e-6, kept = 0.5 * f.kn * f.area * depth * depth;
  CHECK(booked(-depth, 0).handed == 0);
  CHECK(booked(-depth, 0).unexplained == Approx(-kept).epsilon(0.01));
  CHECK(booked(-depth, 5 * kept).handed == Approx(4 * kept).epsilon(0.01));
}

TEST_CASE("what bonds have rubbed and handed over is checked where a checkpoint is read") {
  Model model = recorded(tough_rock(15));
  Team team(1);
  State s;
  add_voronoi_grains(model, voronoi_packing(box_space(Vec3(12e-3, 6e-3, 6e-3)), 8, 5, 1, team), 0, s);
  prepare(model, s, team);
  CHECK_NOTHROW(check_state(model, s));
  for (double FaceBond::*column : {&FaceBond::slip_1, &FaceBond::slip_3, &FaceBond::rubbed, &FaceBond::friction}) {
    State wrong = s;
    wrong.bonds.face.row.back().*column = NAN;
    CHECK_THROWS_AS(check_state(model, wrong), InputError);
  }
  for (double Ledger::*sum : {&Ledger::bond_friction, &Ledger::handed, &Ledger::most_fracture, &Ledger::most_work}) {
    State wrong = s;
    wrong.ledger.*sum = NAN;
    CHECK_THROWS_AS(check_state(model, wrong), InputError);
  }
  State wrong = s;
  const FaceBond& f = s.bonds.face.row.front();
  wrong.bonds.handed.push_back({f.ends, f.at_a, f.kn, f.area, 0, Vec3::Zero(), 1 / (f.kt * f.area), 0, 0, 0});
  CHECK_NOTHROW(check_state(model, wrong));
  wrong.bonds.handed.back().fresh = 2 * f.area;
  CHECK_THROWS_AS(check_state(model, wrong), InputError);
  for (double BrokenBond::*number : {&BrokenBond::time, &BrokenBond::area, &BrokenBond::energy, &BrokenBond::sliding}) {
    State gone = s;
    gone.bonds.broken.push_back({1e-6, Vec3::Zero(), 1e-6, 1e-3, 0, 1, Vec3::UnitX(), 0.5});
    CHECK_NOTHROW(check_state(model, gone));
    gone.bonds.broken.back().*number = NAN;
    CHECK_THROWS_AS(check_state(model, gone), InputError);
  }
}

TEST_CASE("all faces break at once: each takes G A, and a run goes on from there with the same bits") {
  Model model = recorded(tough_rock(15));
  model.numerics.time_step = 2e-8;
  Team team(1);
  State s;
  add_voronoi_grains(model, voronoi_packing(box_space(Vec3(30e-3, 6e-3, 6e-3)), 100, 5, 1, team), 0, s);
  const std::size_t bonds = s.bonds.size();
  for (Motion& m : s.grains.motion) m.velocity = 3000 * (m.position - Vec3(15e-3, 3e-3, 3e-3));
  prepare(model, s, team);
  const double start = stored_energy(model, s);
  const Vec3 p = momentum(s.grains);
  std::size_t most = 0;
  for (int k = 0; k < 400 && !s.bonds.face.row.empty(); ++k) {
    const std::size_t had = s.bonds.size();
    run_steps(model, s, 1, team);
    most = std::max(most, had - s.bonds.size());
  }
  CHECK(s.bonds.empty());
  CHECK(s.bonds.broken.size() == bonds);
  CHECK(most > bonds / 20);
  check_fracture(s, 15);
  CHECK((momentum(s.grains) - p).norm() < 1e-12);
  CHECK(stored_energy(model, s) + s.ledger.spent() == Approx(start).epsilon(1e-3));
  State again = state_of(bytes_of(s));
  for (State* state : {&s, &again}) run_steps(model, *state, 100, team);
  CHECK(hash(s) == hash(again));
}
