// SPDX-License-Identifier: LGPL-3.0-or-later
// What holds and loads cells from outside: glued walls, dead loads, rollers, a constant mean stress.
#include "dem/bond/supports.hpp"
#include "dem/contact/hull_pairs.hpp"
#include "dem/io/archive.hpp"
#include "dem/motion/critical_step.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/bonded.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

Wall plane(const Vec3& point, const Vec3& normal, const Vec3& velocity = Vec3::Zero()) {
  Wall wall;
  wall.point = point, wall.shape = PlaneWall{normal}, wall.velocity = velocity, wall.material = 1;
  return wall;
}

/// A box of cells between walls that hold it: six that slide, or two at the ends along z that do not.
struct Glued {
  State state;
  Tessellation cells;

  Glued(const Model& model, const Vec3& box, std::size_t count, bool slides, Team& team)
      : cells(voronoi_packing(box_space(box), count, 5, 1, team)) {
    const BondedFaces faces = add_voronoi_grains(model, cells, 0, state);
    for (int k = slides ? 0 : 2; k < 3; ++k)
      for (const double side : {-1.0, 1.0}) {
        double offset;
        const auto found = faces_towards(faces.outer, side * Vec3::Unit(k), offset);
        state.boundary.walls.push_back(plane(offset * side * Vec3::Unit(k), -side * Vec3::Unit(k)));
        glue(model, found, static_cast<Index>(state.boundary.walls.size() - 1), slides, state);
      }
  }
};

/// One cube of unit side, alone, with a bond model.
State cube(const Model& model, BondedFaces& faces, Team& team) {
  State s;
  faces = add_voronoi_grains(model, voronoi(box_space(Vec3(1, 1, 1)), {Vec3(0.5, 0.5, 0.5)}, team), 0, s);
  return s;
}

std::vector<OuterFace> end_of(const BondedFaces& faces, const Vec3& direction) {
  double offset;
  return faces_towards(faces.outer, direction, offset);
}

}  // namespace

TEST_CASE(
    "a homogeneous strain goes on to walls that cells are glued to: no cell feels a force, walls bear E times it") {
  Team team(1);
  for (const bool slides : {false, true}) {
    const Model model = rock(elastic(1));
    Glued g(model, Vec3(4, 4, 6), 100, slides, team);
    State& s = g.state;
    const Mat3 strain = (slides ? Vec3(3e-5, -2e-5, 5e-5) : Vec3(0, 0, 5e-5)).asDiagonal();
    for (std::size_t i = 0; i < s.grains.size(); ++i) s.grains.motion[i].position += strain * g.cells.seed[i];
    for (Wall& wall : s.boundary.walls) wall.point += strain * wall.point;
    update_frames(s.grains);
    Ledger ledger;
    bond_forces(s.grains, s.boundary.cell, s.bonds, ledger, team);
    support_forces(s.grains, s.boundary, s.bonds, ledger, 0);
    const double whole = E0 * 16 * 5e-5;
    for (std::size_t i = 0; i < s.grains.size(); ++i) {
      CHECK(s.grains.force[i].norm() < 1e-7 * whole);
      CHECK(s.grains.torque[i].norm() < 1e-4 * whole);  // faces do not turn: of the order of the strain
    }
    const Vec3 f = support_force(s.bonds, slides ? 5 : 1);
    CHECK(f.z() == Approx(-whole).epsilon(1e-4));
    CHECK(f.head<2>().norm() < 1e-7 * whole);
    const double energy = 0.5 * E0 * (strain * strain).trace() * 96;
    CHECK(stored_energy(s.bonds) == Approx(energy).epsilon(1e-4));
    if (!slides) continue;
    const Measurement m = measure(model, s);
    for (int k = 0; k < 3; ++k) CHECK(m.wall_stress(k, k) == Approx(E0 * strain(k, k)).epsilon(1e-4));
    CHECK((m.stress - m.wall_stress).norm() < 1e-4 * m.wall_stress.norm());
  }
}

TEST_CASE("a cube glued to walls: modulus of half its size, critical step of its own mode, no contact besides") {
  Team team(1);
  Model model = rock(elastic(1));
  BondedFaces faces;
  State s = cube(model, faces, team);
  s.boundary.walls = {plane(Vec3::Zero(), Vec3::UnitZ()), plane(Vec3::UnitZ(), -Vec3::UnitZ())};
  glue(model, end_of(faces, -Vec3::UnitZ()), 0, false, s);
  glue(model, end_of(faces, Vec3::UnitZ()), 1, false, s);
  CHECK(s.bonds.wall.at(0).kn == Approx(E0 / 0.5));
  s.grains.motion[0].position.z() -= 1e-4;  // pressed: the bond bears it all
  prepare(model, s, team);
  CHECK(s.contacts.size() == 0);
  // Rocking: k (1/12 + 1/4) at both ends over an inertia of m / 6.
  const double shift = s.bonds.wall[0].kn / density;
  CHECK(critical_step(model.law, model.pairs, 2, s.grains, s.boundary, s.contacts, s.bonds).dt ==
        Approx(2 / std::sqrt(4 * shift)).epsilon(1e-3));
  // What is left over of both faces, over what a link carries on average: both push the same way.
  Ledger ledger;
  clear_supported(s.grains, s.bonds);
  s.grains.force[0] = s.grains.torque[0] = Vec3::Zero();
  support_forces(s.grains, s.boundary, s.bonds, ledger, 0);
  CHECK(measure(model, s).unbalanced_force == Approx(2));
  s.bonds.face.row.push_back(s.bonds.wall[0]);  // a third link, of the grain with itself: as much force again
  CHECK(measure(model, s).unbalanced_force == Approx(2));
  s.bonds.face.row.back().force.setZero();
  CHECK(measure(model, s).unbalanced_force == Approx(3));
  s.bonds.face.row.clear();
  for (const FaceBond& b : s.bonds.wall) {  // glue does not break, whichever criterion reads it
    CHECK((b.tension == INFINITY && b.cohesion == INFINITY && b.energy_1 == INFINITY && b.energy_2 == INFINITY));
    CHECK((b.tan_phi == 0 && b.friction == 0));
  }
  run_steps(model, s, 1, team);
  CHECK(support_force(s.bonds, 0).z() == Approx(-1e-4 * 2 * E0).epsilon(0.2));
}

TEST_CASE(
    "a plate that holds by the normal alone has no force along itself, however far what it holds has slid or leans") {
  Team team(1);
  for (const bool slides : {true, false}) {
    Model model = rock(elastic(1));
    BondedFaces faces;
    State s = cube(model, faces, team);
    s.boundary.walls = {plane(Vec3::Zero(), Vec3::UnitZ())};
    glue(model, end_of(faces, -Vec3::UnitZ()), 0, slides, s);
    const Vec3 rest = s.grains.motion[0].position;
    const Quat upright = s.grains.orientation[0];
    const auto energy_at = [&](const Vec3& shift, const Vec3& turn, Vec3* force = nullptr, Vec3* torque = nullptr) {
      s.grains.motion[0].position = rest + shift;
      s.grains.orientation[0] = Quat(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * upright;
      update_frames(s.grains);
      clear_supported(s.grains, s.bonds);
      Ledger ledger;
      support_forces(s.grains, s.boundary, s.bonds, ledger, 0);
      if (force) *force = s.grains.force[0], *torque = s.grains.torque[0];
      return stored_energy(s.bonds);
    };
    const Vec3 slid(0.3, -0.2, -1e-3), leans(0.01, -0.02, 0.03);
    Vec3 force, torque;
    energy_at(slid, leans, &force, &torque);
    // Of the slope of the energy: the force on the middle of the face, whose height is that of the corner it turns
    // with.
    const Quat q(Eigen::AngleAxisd(leans.norm(), leans.normalized()));
    const double pressed = -(slid + Vec3(0, 0, 0.5) + q * Vec3(0, 0, -0.5)).z();
    CHECK(force.z() == Approx(s.bonds.wall[0].kn * pressed).epsilon(1e-12));
    if (slides) CHECK(force.head<2>().norm() < 1e-12 * force.z());
    constexpr double step = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Vec3 d = step * Vec3::Unit(k);
      const auto turned = [&](double sign) {
        const Eigen::AngleAxisd all(Quat(Eigen::AngleAxisd(sign * step, Vec3::Unit(k))) * q);
        return energy_at(slid, all.angle() * all.axis());
      };
      const double size = force.norm() + torque.norm();
      CHECK(std::abs((energy_at(slid + d, leans) - energy_at(slid - d, leans)) / (2 * step) + force[k]) < 1e-6 * size);
      CHECK(std::abs((turned(1) - turned(-1)) / (2 * step) + torque[k]) < 1e-6 * size);
    }
  }
}

TEST_CASE("moving clamps and dead loads work as much as is held, moves and is damped") {
  Team team(2);
  Model model = rock(elastic(0.4));
  model.numerics.safety = 0.1;
  State s;
  const BondedFaces faces = add_voronoi_grains(model, voronoi_packing(box_space(Vec3(6, 2, 2)), 30, 5, 1, team), 0, s);
  s.boundary.walls.push_back(plane(Vec3(0, 0, 0), Vec3::UnitX(), Vec3(-0.2, 0.1, 0)));
  glue(model, end_of(faces, -Vec3::UnitX()), 0, false, s);
  const Vec3 force(0.3 * E0 * 1e-3, 0, -0.1 * E0 * 1e-3);
  add_load(end_of(faces, Vec3::UnitX()), force, 0.004, s);
  prepare(model, s, team);
  Vec3 momentum = Vec3::Zero(), pushed = Vec3::Zero();
  for (int k = 0; k < 400; ++k) {
    run_steps(model, s, 5, team);
    const double growth = std::min(1.0, s.time / 0.004);
    Vec3 felt = Vec3::Zero();
    for (const DeadLoad& load : s.bonds.load) felt += load.felt;
    CHECK((felt - growth * force).norm() < 1e-9 * force.norm());
    pushed += felt;
  }
  for (std::size_t i = 0; i < s.grains.size(); ++i) momentum += s.grains.mass[i] * s.grains.motion[i].velocity;
  CHECK(s.time > 0.008);
  CHECK(s.ledger.work > 0);
  CHECK(stored_energy(s.bonds) > 0.01 * s.ledger.work);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-4);
  CHECK(momentum.norm() > 0);
  // The same from a file, bit for bit, and on one thread.
  State again = state_of(bytes_of(s));
  Team alone(1);
  run_steps(model, s, 100, team), run_steps(model, again, 100, alone);
  CHECK(hash(s) == hash(again));
}

TEST_CASE("a dead load alone: momentum is force times time, half of it while it grows; off the centre it turns") {
  Team team(1);
  Model model = rock(elastic(1));
  model.numerics.time_step = 1e-5;
  for (const double ramp : {0.0, 0.01}) {
    BondedFaces faces;
    State s = cube(model, faces, team);
    const Vec3 force(0, 0, 500);
    add_load(end_of(faces, Vec3::UnitX()), force, ramp, s);
    prepare(model, s, team);
    run_steps(model, s, 1000, team);
    // The first kick has not met the load yet: half a step of a thousand.
    const double impulse = s.grains.mass[0] * s.grains.motion[0].velocity.z();
    CHECK(impulse == Approx(500 * 0.01 * (ramp > 0 ? 0.5 : 1)).epsilon(1e-3));
    // Torque of 250 N m on an inertia of m / 6.
    CHECK(s.grains.motion[0].spin.y() ==
          Approx(-250 * 0.01 * (ramp > 0 ? 0.5 : 1) / (s.grains.mass[0] / 6)).epsilon(1e-3));
    CHECK(s.ledger.work == Approx(kinetic_energy(s.grains)).epsilon(2e-3));
  }
}

TEST_CASE("a dead load that grows within few steps works by the trapezoid: kinetic energy but for half a kick's") {
  Team team(1);
  Model model = rock(elastic(1));
  model.numerics.time_step = 1e-5;
  BondedFaces faces;
  State s = cube(model, faces, team);
  const double force = 5e8, steps = 10;  // large, so that ways are far above round-off
  add_load(end_of(faces, Vec3::UnitX()), Vec3(force, 0, 0), steps * 1e-5, s);  // through the centre: nothing turns
  prepare(model, s, team);
  for (double k = 1; k <= steps; ++k) {
    run_steps(model, s, 1, team);
    // A step of the leapfrog adds (F + F') / 2 dx + (F'^2 - F^2) dt^2 / 8 m to the kinetic energy.
    const double felt = force * k / steps, kick = felt * felt * 1e-10 / (8 * s.grains.mass[0]);
    CHECK(std::abs(s.ledger.work - (kinetic_energy(s.grains) - kick)) < 1e-9 * kinetic_energy(s.grains));
  }
}

TEST_CASE(
    "a roller is a hull that does not turn: the force of the pair, along its way, from whatever distance it comes") {
  Team team(1);
  Model model = rock(elastic(1));
  model.numerics.safety = 0.02;
  State s;
  HullStore store;
  HullPlace place;
  GrainSpec brick;
  brick.hull = add_hull(store, box_between(Vec3(-2, -1, -0.5), Vec3(2, 1, 0.5)), place);
  brick.orientation = place.axes, brick.density = density;
  const Index shape = add_unturned(store, box_between(Vec3(-0.3, -3, -0.3), Vec3(0.3, 3, 0.3)));
  s.grains.hulls = std::make_shared<HullStore>(store);
  set_grain(s.grains, 0, brick);
  Wall wall = plane(Vec3(0.5, 0, 4.8), Vec3::Zero(), Vec3(0, 0, -20));
  wall.shape = RollerWall{Vec3::UnitY(), 0.45, shape};
  s.boundary.walls.push_back(wall);
  CHECK(wall.distance(Vec3(0.5, 7, 0.8)) == Approx(4 - 0.45));
  update_frames(s.grains);
  Wall deep = wall;
  deep.point = Vec3(0.5, 0, 0.5 + 0.3 - 0.01);
  const Overlap o = overlap_at_wall(s.grains, deep, 0);
  CHECK(o.volume > 0);
  CHECK(o.force.x() == Approx(0).margin(1e-12));
  CHECK(o.force.z() == Approx(o.area.norm() * 0.01).epsilon(1e-6));
  CHECK(o.middle.x() == Approx(0.5).margin(1e-9));
  prepare(model, s, team);
  CHECK(s.contacts.size() == 0);
  // It comes from far beyond what the first list reaches, at 20 m/s, and throws the brick at some 40 less what spins.
  for (int k = 0; k < 4000 && s.time < 0.25; ++k) run_steps(model, s, 20, team);
  CHECK(s.grains.motion[0].velocity.z() < -20);
  CHECK(s.grains.motion[0].velocity.z() > -41);
  CHECK(s.grains.motion[0].spin.y() > 0.1);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-3);
}

TEST_CASE("a bar of slices that softens bears its bonds' strength and takes G A, however thin the slices are") {
  Team team(1);
  const double strength = 1e6, energy = 1e4;  // gives way over 20 mm, stretched by 8 mm
  Model model = rock(cohesive(strength, energy));
  set_damping(model, 0.1);
  model.numerics.safety = 0.8;
  for (const std::size_t slices : {8u, 16u, 32u}) {
    std::vector<Vec3> seeds;
    const double thick = 8.0 / static_cast<double>(slices);
    for (std::size_t k = 0; k < slices; ++k) seeds.emplace_back(0.5, 0.5, (static_cast<double>(k) + 0.5) * thick);
    State s;
    const BondedFaces faces = add_voronoi_grains(model, voronoi(box_space(Vec3(1, 1, 8)), seeds, team), 0, s);
    REQUIRE(s.bonds.face.row.size() == slices - 1);
    s.bonds.face.row[slices / 3].tension *= 0.98;  // where it is to part
    for (const double side : {-1.0, 1.0}) {
      s.boundary.walls.push_back(
          plane(Vec3(0, 0, side < 0 ? 0 : 8), -side * Vec3::UnitZ(), Vec3(0, 0, side < 0 ? 0 : 5e-3)));
      glue(model, end_of(faces, side * Vec3::UnitZ()), static_cast<Index>(s.boundary.walls.size() - 1), false, s);
    }
    prepare(model, s, team);
    double peak = 0;
    while (s.ledger.bonds_broken == 0 && s.time < 8) {
      run_steps(model, s, 20, team);
      peak = std::max(peak, std::abs(support_force(s.bonds, 1).z()));
    }
    CAPTURE(slices, s.time);
    CHECK(s.ledger.bonds_broken == 1);
    CHECK(peak == Approx(0.98 * strength).epsilon(0.02));  // a wave of its pull is 0.7 %
    CHECK(s.ledger.fracture == Approx(energy).epsilon(2e-3));
    CHECK(s.ledger.work == Approx(energy).epsilon(0.05));
  }
}

namespace {

/// Tension across the middle of a disc under two arcs of dead load, over 2 P / (pi D t) of a disc of one piece: the
/// mean of the cells within 0.15 of its radius, from what their bonds do to them.
double tension_across(std::uint64_t seed, Team& team) {
  constexpr double diameter = 40, thickness = 1, load = 1e-4 * E0 * diameter * thickness;
  Model model = rock(elastic(0.4));
  set_damping(model, 0.6);
  model.numerics.safety = 0.9;
  TessellationSpace space = cylinder_space(diameter, thickness);
  space.extruded = true;
  State s;
  const BondedFaces faces = add_voronoi_grains(model, voronoi_packing(space, 1500, 5, seed, team), 0, s);
  const Vec3 middle(diameter / 2, diameter / 2, thickness / 2);
  double arc = 0;
  for (const double side : {-1.0, 1.0}) {
    std::vector<OuterFace> pressed;
    for (const OuterFace& f : faces.outer)
      if (f.normal.y() * side > std::cos(0.1)) pressed.push_back(f), arc += f.face.area / (2 * thickness * diameter);
    add_load(pressed, Vec3(0, -side * load, 0), 0, s);
  }
  prepare(model, s, team);
  run_for(model, s, 0.4, team);  // four times across by the slower wave: at rest to 1e-10 of what is held
  CHECK(stored_energy(model, s) - stored_energy(s.bonds) < 1e-6 * stored_energy(s.bonds));
  double sum = 0, volume = 0;
  const auto inside = [&](Index i) {
    return (s.grains.motion[i].position - middle).head<2>().norm() < 0.075 * diameter;
  };
  for (Index i = 0; i < s.grains.size(); ++i)
    if (inside(i)) volume += s.grains.mass[i] / density;
  for (const FaceBond& b : s.bonds.face.row) {
    const Vec3 point = s.grains.motion[b.ends.b].position + s.grains.orientation[b.ends.b] * b.at_b;
    for (const auto& [i, sign] : {std::pair{b.ends.a, -1.0}, std::pair{b.ends.b, 1.0}})
      if (inside(i)) sum += sign * b.force.x() * (point - s.grains.motion[i].position).x();
  }
  return sum / volume / (2 * load / (pi * diameter * thickness)) / ((std::sin(2 * arc) - arc) / arc);
}

}  // namespace

TEST_CASE("a disc pressed on two arcs is drawn across its middle as one of a single piece is") {
  Team team(2);
  double mean = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const double found = tension_across(seed, team);
    // Two Flamant fields and a uniform one over arcs of 0.1 rad, their mean over 0.15 R: 0.964; here over (sin 2a - a)
    // / a = 0.987.
    CHECK(found == Approx(0.977).margin(0.12));
    mean += found / 3;
  }
  CHECK(mean == Approx(0.977).margin(0.05));
}

TEST_CASE("a constant mean stress: kept while one axis is pressed; in an elastic cell the volume stays, too") {
  Team team(2);
  Model model = rock(elastic(1));
  set_damping(model, 0.5);
  State s;
  s.boundary.cell.vectors = 4 * Mat3::Identity();
  add_voronoi_grains(model, voronoi_packing(periodic_space(Vec3::Constant(4)), 64, 5, 1, team), 0, s);
  prepare(model, s, team);
  Loading loading;
  loading.driven = true, loading.mean = -1e-4 * E0, loading.consolidation = 1;
  for (AxisControl& axis : loading.axes) axis = {0, *loading.mean, 6e-3};
  loading.axes[2] = {.strain_rate = -1e-3, .stress = {}, .max_rate = 6e-3};
  begin_loading(model, s, loading);
  REQUIRE(load(model, s, loading, 1, team));
  const Vec3 held = measure(model, s).stress.diagonal();
  for (int k = 0; k < 3; ++k) CHECK(held[k] == Approx(*loading.mean).epsilon(0.02));
  const double before = s.boundary.cell.volume(), height = s.boundary.cell.vectors(2, 2);
  REQUIRE(load(model, s, loading, 1.3, team));
  const Vec3 sheared = measure(model, s).stress.diagonal();
  CHECK(sheared.mean() == Approx(*loading.mean).epsilon(0.01));
  CHECK(s.boundary.cell.vectors(2, 2) / height == Approx(1 - 3e-4).epsilon(1e-6));
  CHECK(s.boundary.cell.volume() / before - 1 == Approx(0).margin(0.02 * 3e-4));
  // sigma_z - sigma_x = 3 G e, E = 2 G here.
  CHECK(sheared.x() - sheared.z() == Approx(1.5 * E0 * 3e-4).epsilon(0.03));
}
