// SPDX-License-Identifier: LGPL-3.0-or-later
// Cells and boxes that are driven: turned onto other axes, sheared without end, held at a stress, ended at one; and
// what their energy is measured against.
#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/real_time.hpp"
#include "dem/rve/reduce_cell.hpp"
#include "dem/rve/servo.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/held_walls.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

Model sand() {
  Model model = model_of(solid(10e9, 0.2, 2650, 0.5, 0.5));
  set_damping(model, 0.2);
  return model;
}

State packed(bool periodic, double size = 8e-3) {
  State s;
  const Packing p = random_packing(Vec3::Constant(size), {"uniform", 1e-3, 0, 0.8e-3, 1.2e-3}, periodic ? 0.57 : 0.53,
                                   0, periodic, 1);
  for (const auto& sphere : p.spheres) add(s, PolyEllipsoid::sphere(sphere.radius), sphere.position, 2650);
  if (periodic)
    s.boundary.cell.vectors = size * Mat3::Identity();
  else
    add_box(s, size);
  return s;
}

QuasiStatic fast() {
  QuasiStatic q;
  q.inertial_number = 5e-3;
  return q;
}

/// A cell of some seventy grains at 1 MPa, made once; its ledger begins here.
State at_pressure(const Model& model) {
  static const State state = [] {
    State s = packed(true);
    Team team(1);
    const Model sand_alone = sand();
    prepare(sand_alone, s, team);
    compress_isotropically(sand_alone, fast(), s, 1e6, team);
    return s;
  }();
  State s = state;
  s.ledger = {}, s.time = 0, s.steps = 0;
  Team team(1);
  prepare(model, s, team);
  return s;
}

Mat3 stress_of(const State& s) { return love_weber(s, s.boundary.cell.volume()); }

}  // namespace

TEST_CASE("turned by a right angle or onto other axes, a cell goes on as it would have, turned") {
  const Model model = sand();
  Team team(1);
  Increment squeeze;
  squeeze.deformation(0, 0) -= 1e-3, squeeze.deformation(0, 2) += 5e-4;
  State plain = at_pressure(model);
  const Mat3 first = deform(model, fast(), plain, {}, team).stress;
  const Mat3 second = deform(model, fast(), plain, squeeze, team).stress;
  REQUIRE(-first.trace() / 3 > 0.9e6);
  Mat3 quarter, axes, upside_down;
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  upside_down << 0, 0, 1, 0, -1, 0, 1, 0, 0;
  for (const Mat3& r : {quarter, axes, upside_down}) {
    State s = at_pressure(model);
    const Response turned = deform(model, fast(), s, {r}, team);
    CHECK(s.boundary.cell.vectors(0, 0) == 0);
    CHECK((turned.stress - r * first * r.transpose()).norm() < 1e-9 * first.norm());
    const Mat3 f = r * squeeze.deformation * r.transpose();
    CHECK((deform(model, fast(), s, {f}, team).stress - r * second * r.transpose()).norm() < 1e-6 * second.norm());
    State in_time = at_pressure(model);
    State still = in_time;
    const Response moved = respond_in_time(model, in_time, r, 1e-5, false, team);
    const Mat3 rested = respond_in_time(model, still, Mat3::Identity(), 1e-5, false, team).stress;
    CHECK((moved.stress - r * rested * r.transpose()).norm() < 1e-9 * rested.norm());
  }
}

TEST_CASE("the shortest edges of a lattice: sheared cells, and skew ones in all three directions") {
  Mat3 sheared = Mat3::Identity();
  sheared(0, 2) = 2.3;
  Mat3 back = sheared * shortest_edges(sheared), wanted = Mat3::Identity();
  wanted(0, 2) = 0.3;
  CHECK((back - wanted).norm() < 1e-12);
  CHECK(shortest_edges(wanted) == Mat3::Identity());
  Mat3 box = Vec3(1, 1.3, 4).asDiagonal(), skew;
  skew << 1, 7, -40, 0, 1, 5, 0, 0, 1;
  Mat3 other;
  other << 1, 0, 0, -3, 1, 0, 11, 2, 1;
  const Mat3 found = box * skew * other * shortest_edges(box * skew * other);
  Vec3 lengths = found.colwise().norm();
  std::sort(lengths.begin(), lengths.end());
  CHECK((lengths - Vec3(1, 1.3, 4)).norm() < 1e-9);
  CHECK(found.determinant() == Approx(box.determinant()));  // not turned inside out
  // Edges that no pair shortens, but all three do: the body diagonal's half of a flat cube.
  Mat3 flat;
  flat << 1, 0.5, 0.5, 0, 0.75, 0.5, 0, 0, 0.2;
  const Mat3 m = shortest_edges(flat);
  CHECK(m.determinant() == Approx(1));
  const Mat3 least = flat * m;
  for (int i = -1; i < 2; ++i)
    for (int j = -1; j < 2; ++j)
      if (i != 0 || j != 0)
        CHECK((least.col(2) + i * least.col(0) + j * least.col(1)).norm() > least.col(2).norm() * (1 - 1e-9));
}

TEST_CASE("a cell that is cut anew is the same cell: stress, energy, what follows, also from a checkpoint") {
  Model model = sand();
  model.numerics.reduce_cell_at = INFINITY;
  Team team(1);
  State s = at_pressure(model);
  const Mat3 began = s.boundary.cell.vectors;
  Mat3 shear = Mat3::Identity();
  shear(0, 2) = 0.05;
  for (int k = 0; k < 28; ++k) deform_in_time(model, s, shear, 1e-4, team);
  REQUIRE(s.boundary.cell.whole == Mat3::Identity());
  State cut = s;
  CHECK_FALSE(reduce_cell(cut, 3));
  REQUIRE(reduce_cell(cut, 1.5));
  CHECK(cut.boundary.cell.height() > 1.5 * s.boundary.cell.height());
  // What it was when its list was made is told by the same edges: the strain since is no other.
  const auto since = [](const State& of) { return Mat3(of.boundary.cell.vectors * of.reference.cell.inverse()); };
  CHECK((since(cut) - since(s)).norm() < 1e-12);
  CHECK(cut.boundary.cell.whole != Mat3::Identity());
  CHECK((cut.boundary.cell.began() * began.inverse() - s.boundary.cell.vectors * began.inverse()).norm() < 1e-12);
  const Mat3 before = stress_of(s);
  REQUIRE(before.norm() > 1e5);
  CHECK((stress_of(cut) - before).norm() < 1e-12 * before.norm());
  CHECK(stored_energy(model, cut) == Approx(stored_energy(model, s)).epsilon(1e-14));
  s.reference.stale = cut.reference.stale = true;  // new lists: histories are found again
  State kept = state_of(bytes_of(cut));
  for (State* of : {&s, &cut, &kept}) deform_in_time(model, *of, shear, 1e-4, team);
  CHECK(hash(cut) == hash(kept));
  const Mat3 after = stress_of(s);
  CHECK((after - before).norm() > 1e-3 * before.norm());
  CHECK((stress_of(cut) - after).norm() < 1e-7 * after.norm());
  CHECK(cut.ledger.friction == Approx(s.ledger.friction).epsilon(1e-7));
  CHECK(cut.ledger.work == Approx(s.ledger.work).epsilon(1e-7));
}

TEST_CASE("a shear goes on for ever: five times the height of the cell, with the energy in order") {
  const Model model = sand();
  Team team(1);
  State s = at_pressure(model);
  const Mat3 began = s.boundary.cell.vectors;
  Loading loading;
  loading.velocity_gradient = Mat3::Zero();
  (*loading.velocity_gradient)(0, 2) = 500;
  begin_loading(model, s, loading);
  for (int k = 1; k <= 20; ++k) {
    load(model, s, loading, 5e-4 * k, team);
    check_sanity(model, s);
  }
  CHECK(s.boundary.cell.whole != Mat3::Identity());
  CHECK(s.boundary.cell.height() > 0.6 * began(0, 0));
  const Mat3 gradient = displacement_gradient(s, loading, began);
  CHECK(gradient(0, 2) == Approx(5).epsilon(1e-6));
  CHECK(std::abs(gradient(2, 0)) < 1e-6);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.01);
  CHECK(stress_of(s)(0, 2) > 0.1e6);
}

TEST_CASE("an axis may follow its stress at an inertial number of 0.03, or at its own rate where that is faster") {
  State s;
  for (int k = 0; k < 3; ++k) add(s, PolyEllipsoid::sphere(2e-3), Vec3(k * 5e-3, 0, 0), 2500);
  const double rate = 0.03 / (4e-3 * std::sqrt(2500 / 1e5));  // I = rate d sqrt(rho / p)
  CHECK(fastest_rate(s, {.strain_rate = 0, .stress = -1e5, .max_rate = 0.5 * rate}, 1e5) ==
        Approx(rate).epsilon(1e-12));
  CHECK(fastest_rate(s, {.strain_rate = 0, .stress = -1e5, .max_rate = 3 * rate}, 1e5) == 3 * rate);
}

TEST_CASE("a triaxial test holds its lateral stress, in a cell and between walls") {
  const Model model = sand();
  Team team(1);
  for (const bool periodic : {true, false}) {
    State s;
    if (periodic) {
      s = at_pressure(model);
    } else {
      s = packed(false, 12e-3);
      prepare(model, s, team);
    }
    Loading loading;
    loading.driven = true;
    if (!periodic) {
      for (auto& axis : loading.axes) axis = {0, -1e6, 100};
      begin_loading(model, s, loading);
      load(model, s, loading, 8e-3, team);
      s.time = 0;
    }
    for (auto& axis : loading.axes) axis = {0, -1e6, 40};
    loading.axes[2] = {.strain_rate = -20, .stress = {}};
    loading.holds = true;
    begin_loading(model, s, loading);
    double sum = 0;
    constexpr int rows = 100;
    for (int k = 1; k <= rows; ++k) {
      load(model, s, loading, 0.05 / 20 * k / rows, team);
      const double off = stress_error(s, loading, measure(model, s));
      if (k > rows / 2) sum += 2 * off;  // the walls have found the sample by then
    }
    INFO(periodic);
    CHECK(sum / rows < (periodic ? 0.01 : 1e-3));
    const Measurement m = measure(model, s);
    CHECK((periodic ? m.stress : m.wall_stress)(2, 2) < -1.3e6);
    CHECK(stress_error(s, loading, m) < 0.03);
  }
}

TEST_CASE("walls that press hold their force at any rate, carry the weight of a sample and stop its drift") {
  Model model = sand();
  Team team(1);
  State s = packed(false);
  prepare(model, s, team);
  Loading loading = hold_by_walls(model, s, team);
  const auto off = [&] { return stress_error(s, loading, measure(model, s)); };
  CHECK(off() < 1e-3);
  const State pressed = s;
  const auto mean = [&] {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < s.grains.size(); ++i) sum += s.grains.mass[i] * s.grains.motion[i].velocity;
    return Vec3(sum / total_mass(s.grains));
  };
  for (const double rate :
       {20.0, 100.0, 400.0}) {  // 20/s lag a wave behind with one wall that moves: 1.1 %; 400/s: 35 %
    s = pressed, s.time = 0;
    for (auto& axis : loading.axes) axis = {0, -1e6, 2 * rate};
    loading.axes[2] = {.strain_rate = -rate, .stress = {}};
    begin_loading(model, s, loading);
    double sum = 0;
    for (int k = 1; k <= 40; ++k) load(model, s, loading, 0.05 / rate * k / 40, team), sum += off() / 40;
    INFO(rate);
    CHECK(sum < 5e-3);
    CHECK(-measure(model, s).wall_stress(2, 2) > 1.5e6);
  }
  // A thousand times its weight sideways, 2 % of the walls' force: it does not fall, each carries half, the mean holds.
  s = pressed;
  for (auto& axis : loading.axes) axis = {0, -1e6, 100};
  model.motion.gravity = Vec3(-1e4, 0, 0);
  begin_loading(model, s, loading);
  const double began = s.time;
  load(model, s, loading, began + 1e-3, team);
  CHECK(std::abs(mean().x()) < 0.02 * 1e4 * 1e-3);
  CHECK(off() < 1e-3);
  double push = 0;
  for (std::size_t k = s.contacts.begin[first_wall]; k < s.contacts.size(); ++k)
    if (std::abs(s.boundary.walls[s.contacts.pair[k].b].facing().x()) == 1) push += s.contacts.touch[k].force.x();
  CHECK(push == Approx(-1e4 * total_mass(s.grains)).epsilon(0.05));  // of the grains on the walls
  // A push from the side, nothing that rubs or damps: gone after some ten times the way of the pressure.
  s = pressed;
  model.motion.gravity.setZero();
  set_damping(model, 0);
  for (auto& pair : model.pairs) pair.friction = {};
  for (auto& motion : s.grains.motion) motion.velocity.x() += 0.1;
  begin_loading(model, s, loading);
  load(model, s, loading, began + 3e-3, team);
  CHECK(std::abs(mean().x()) < 0.01);
  CHECK(off() < 1e-3);
}

TEST_CASE("a test ends at the stress that ends it, within a step") {
  const Model model = sand();
  Team team(1);
  State s = at_pressure(model);
  Loading loading;
  loading.driven = true;
  loading.axes[2] = {.strain_rate = -20, .stress = {}};
  begin_loading(model, s, loading);
  const Landing landing{.left = [](const State& at) { return 2e6 + stress_of(at)(2, 2); }, .near = 4e5, .axis = 2};
  CHECK(load(model, s, loading, 1e-2, team, {}, landing));
  CHECK(s.time < 5e-3);
  const double reached = -stress_of(s)(2, 2);
  run_steps(model, s, 1, team);
  const double step = std::abs(-stress_of(s)(2, 2) - reached);
  CHECK(reached >= 2e6);
  CHECK(reached - 2e6 < std::max(5 * step, 1e3));  // the stress goes up and down by more than its mean gain
}

TEST_CASE("a run that lands on a stress ends in the state in which a look stops it there, bit by bit") {
  const Model model = sand();
  Team team(1);
  const State pressed = at_pressure(model);
  const auto ended = [&](bool stopped) {
    State s = pressed;
    Loading loading;
    loading.driven = true;
    loading.axes[0] = loading.axes[1] = {0, -1e6, 20};
    loading.axes[2] = {.strain_rate = -20, .stress = {}};
    begin_loading(model, s, loading);
    const Landing landing{.left = [](const State& at) { return 2e6 + stress_of(at)(2, 2); }};
    const double end = 1e-2;
    const auto there = [&](double) { return landing.left(s) > 0; };
    CHECK(load(model, s, loading, end, team, stopped ? Watch(there) : Watch(), stopped ? Landing() : landing) ==
          !stopped);
    CHECK(s.time < end);
    return hash(s);
  };
  CHECK(ended(true) == ended(false));
}

TEST_CASE("energy is measured against what was exchanged: a ball that bounces passes, a step too long does not") {
  Material glass = solid(10e6, 0.2, 2500);
  Model model = model_of(glass);
  model.motion.gravity = Vec3(0, 0, -9.81);
  model.numerics.safety = 0.02;  // as in scenes of listed grains
  State s;
  add(s, PolyEllipsoid::sphere(5e-3), Vec3(0, 0, 0.02), 2500);
  add_floor(s);
  Team team(1);
  prepare(model, s, team);
  double worst = 0, old = 0;
  for (int k = 0; k < 200; ++k) {
    run_for(model, s, 2e-3, team);
    CHECK_NOTHROW(check_sanity(model, s));
    const double stored = stored_energy(model, s), error = energy_error(s.ledger, stored);
    worst = std::max(worst, std::abs(error));
    old = std::max(old, std::abs(error) * energy_scale(s.ledger, stored) /
                            std::max({std::abs(s.ledger.work), stored, s.ledger.floor}));
  }
  CHECK(worst < 2e-3);     // of m g h
  CHECK(old > 5 * worst);  // against what is there at the time: at the top of a bounce nothing is

  // Grains that blow up are seen in the same look as by the work and energy of the time alone.
  model = sand();
  model.numerics.max_energy_error = INFINITY;
  State crowd = at_pressure(model);
  model.numerics.time_step = 8 * crowd.dt;
  crowd.next_estimate = 0;
  set_cell_rate(crowd, -20 * crowd.boundary.cell.vectors);
  int seen = 0, seen_before = 0;
  for (int look = 1; look <= 200 && !(seen && seen_before); ++look) {
    try {
      update_time_step(model, crowd);
      run_steps(model, crowd, 5, team);
    } catch (const Unstable&) {
      break;
    }
    const double stored = stored_energy(model, crowd), error = energy_error(crowd.ledger, stored);
    const double then = error * energy_scale(crowd.ledger, stored) /
                        std::max({std::abs(crowd.ledger.work), stored, crowd.ledger.start, crowd.ledger.floor});
    if (!seen && std::abs(error) > 0.05) seen = look;
    if (!seen_before && std::abs(then) > 0.05) seen_before = look;
  }
  CHECK(seen > 0);
  CHECK(seen == seen_before);
}

TEST_CASE("a velocity gradient carries a cell along its exponential, however much of it is done at once") {
  Model model = sand();
  model.numerics.time_step = 1e-2;
  Team team(1);
  Mat3 stretching, turning;
  stretching << 0.5, 0.3, -0.2, 0.3, -0.4, 0.1, -0.2, 0.1, 0.2;
  turning << 0, -0.5, 0.3, 0.5, 0, -0.7, -0.3, 0.7, 0;
  const auto after = [&](const Mat3& gradient) {
    State s;
    for (const double x : {5.0, 15.0}) add(s, PolyEllipsoid::sphere(1), Vec3(x, 10, 10), 2650);
    s.boundary.cell.vectors = 20 * Mat3::Identity();
    prepare(model, s, team);
    Loading loading;
    loading.driven = true, loading.velocity_gradient = gradient;
    begin_loading(model, s, loading);
    load(model, s, loading, 1, team);
    return Mat3(displacement_gradient(s, loading, 20 * Mat3::Identity()) + Mat3::Identity());
  };
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(stretching);
  const Mat3 &q = axes.eigenvectors(), whole = q * Vec3(axes.eigenvalues().array().exp()).asDiagonal() * q.transpose();
  CHECK((after(stretching) - whole).norm() < 1e-12);
  CHECK((after(turning) - rotation_by(Vec3(0.7, 0.3, 0.5)).toRotationMatrix()).norm() < 1e-12);
}
