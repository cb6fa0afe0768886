// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls in motion: falls on faces, edges and vertices in closed form, collisions that keep their energy, towers,
// inclines.
#include "dem/packing/voronoi.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

struct Fall {
  double depth = 0, time = 0, speed = 0, error = 0;
};

/// A unit cube, one of its directions down, meets the floor at `v`; without gravity.
Fall fall(const Vec3& down, double v, double c) {
  Model model = hull_model(0, c);
  model.numerics.time_step = 1e-3 / std::sqrt(c);
  State s;
  const Quat q = Quat::FromTwoVectors(down.normalized(), -Vec3::UnitZ());
  const double reach = 0.5 * down.normalized().cwiseAbs().sum();
  add_body(s, unit_cube(), Vec3(0, 0, reach), q, Vec3(0, 0, -v));
  add_floor(s);
  Team team(1);
  prepare(model, s, team);
  Fall f;
  const double before = kinetic_energy(s.grains);
  for (int k = 0; k < 200000; ++k) {
    run_steps(model, s, 1, team);
    f.depth = std::max(f.depth, reach - s.grains.motion[0].position.z());
    if (s.contacts.size() > 0 && s.contacts.contact.touching(0))
      f.time += s.dt;
    else if (f.time > 0)
      break;
  }
  f.speed = s.grains.motion[0].velocity.z();
  f.error = std::abs(stored_energy(model, s) / before - 1);
  return f;
}

}  // namespace

TEST_CASE("a cube falls on a face as on a spring c A, on an edge and a vertex as their potentials say") {
  const double v = 0.01;
  const Fall face = fall(Vec3(0, 0, 1), v, 1e4);
  CHECK(face.depth == Approx(v * std::sqrt(1 / 1e4)).epsilon(2e-3));
  CHECK(face.time == Approx(pi * std::sqrt(1 / 1e4)).epsilon(2e-3));
  CHECK(face.speed == Approx(v).epsilon(1e-3));
  const Fall edge = fall(Vec3(1, 0, 1), v, 1e4), vertex = fall(Vec3(1, 1, 1), v, 1e4);
  CHECK(edge.depth == Approx(std::cbrt(0.5 * v * v / (0.402369 * 1e4))).epsilon(2e-3));
  CHECK(vertex.depth == Approx(std::pow(0.5 * v * v / (0.295753 * 1e4), 0.25)).epsilon(2e-3));
  for (const Fall& f : {face, edge, vertex}) CHECK(f.error < 1e-5);
}

TEST_CASE("restitution of a cube that falls on its face is the given one") {
  Model model = hull_model(0, 1e4, 0.4);
  model.numerics.time_step = 2e-5;
  State s;
  add_body(s, unit_cube(), Vec3(0, 0, 0.5), Quat::Identity(), Vec3(0, 0, -0.01));
  add_floor(s);
  Team team(1);
  prepare(model, s, team);
  run_for(model, s, 0.2, team);
  CHECK(s.grains.motion[0].velocity.z() == Approx(0.004).epsilon(2e-3));
}

TEST_CASE("a plate that falls on its rim comes back as a cube on its edge of the mass that the blow meets") {
  constexpr double thick = 0.2, fall = 0.01;
  const Quat tilt(Eigen::AngleAxisd(0.25 * pi, Vec3::UnitY()));
  const Vec3 half(0.5, 0.5, 0.5 * thick), rim = tilt * Vec3(half.x(), 0, -half.z());
  const double mass = thick, moment = mass * (1 + thick * thick) / 12;
  const double met = 1 / (1 / mass + rim.x() * rim.x() / moment);  // half of the whole
  CHECK(met < 0.55 * mass);
  Model model = hull_model(0, 1e4, 0.3);
  model.numerics.time_step = 2e-5;
  Team team(1);
  const auto run = [&](const Polyhedron& body, double height, double own) {
    State s;
    add_body(s, body, Vec3(0, 0, height), tilt, Vec3(0, 0, -fall));
    set_inertia(s.grains, 0, own, own);
    add_floor(s);
    prepare(model, s, team);
    run_for(model, s, 0.5, team);
    CHECK(s.contacts.contact.stiffness[0] == 0);
    return s;
  };
  const double came_back = run(unit_cube(), std::sqrt(0.5), met).grains.motion[0].velocity.z();
  const State plate = run(box_between(-half, half), -rim.z(), mass);
  const Motion& m = plate.grains.motion[0];
  CHECK(came_back > 0.1 * fall);
  // It turns by some 0.01 while it touches, and its arm with it.
  CHECK(m.velocity.z() + m.spin.cross(rim).z() == Approx(came_back).epsilon(0.02));
}

TEST_CASE("cells that collide keep energy, momentum and angular momentum; the error falls with the step squared") {
  Team team(1);
  const Tessellation cells = voronoi_packing(periodic_space(Vec3::Constant(4)), 64, 2, 3, team);
  Model model = hull_model(0, 1e4);
  const auto errors = [&](double share) {
    double squares = 0, momentum_off = 0, turn_off = 0;
    constexpr int collisions = 20;
    for (int n = 0; n < collisions; ++n) {
      State s;
      const auto id = static_cast<std::uint64_t>(n);
      for (int side = 0; side < 2; ++side) {
        Polyhedron body = cells.body[static_cast<std::size_t>(3 * n + side)];
        place(body, Mat3::Identity(), -moments_of(body).centre);
        Vec3 spin;
        for (int k = 0; k < 3; ++k)
          spin[k] = 0.2 * random_normal(4, id, Purpose::turn, static_cast<std::uint64_t>(3 * side + k));
        add_body(s, body, Vec3(side ? 1.35 : 0, side ? 0.15 : 0, 0),
                 random_rotation(id, static_cast<std::uint64_t>(side)), Vec3(side ? -1 : 1, 0, 0), spin);
      }
      model.numerics.time_step = share * pi * std::sqrt(0.5 / 1e4);  // of a collision on a whole face
      prepare(model, s, team);
      const double before = stored_energy(model, s);
      const Vec3 p = momentum(s.grains), l = angular_momentum(s.grains);
      bool met = false;
      while (s.time < 1) {
        run_steps(model, s, 20, team);
        met = met || (s.contacts.size() > 0 && s.contacts.contact.touching(0));
        if (met && !s.contacts.contact.touching(0)) break;
      }
      squares += std::pow(stored_energy(model, s) / before - 1, 2) / collisions;
      momentum_off = std::max(momentum_off, (momentum(s.grains) - p).norm());
      turn_off = std::max(turn_off, (angular_momentum(s.grains) - l).norm());
    }
    CHECK(momentum_off < 1e-12);
    CHECK(turn_off < 1e-11);
    return std::sqrt(squares);
  };
  const double coarse = errors(1.0 / 50), fine = errors(1.0 / 200);
  CHECK(coarse < 2e-4);
  CHECK(fine < 0.25 * coarse);  // of second order but where the least deep plane changes: there of first
}

TEST_CASE("a tower of six cubes stands, at the height that its weight leaves it") {
  Model model = hull_model(0.5, 1e5);
  model.materials[0].damping = 0.2;
  make_pair_laws(model);
  model.motion.gravity = Vec3(0, 0, -1);
  State s;
  for (int k = 0; k < 6; ++k) {
    const auto id = static_cast<std::uint64_t>(k);
    const Vec3 tilt(1e-4 * random_normal(2, id, Purpose::turn, 0), 1e-4 * random_normal(2, id, Purpose::turn, 1), 0);
    add_body(s, unit_cube(), Vec3(0, 0, 0.5 + k), rotation_by(tilt));
  }
  add_floor(s);
  Team team(1);
  prepare(model, s, team);
  run_for(model, s, 10, team);
  set_damping(model, 0);
  const double settled = stored_energy(model, s);
  run_for(model, s, 10, team);
  CHECK(s.grains.motion[5].position.z() == Approx(5.5 - 21 / 1e5).margin(1e-7));
  CHECK(kinetic_energy(s.grains) < 1e-10);
  CHECK(stored_energy(model, s) == Approx(settled).margin(1e-9));
}

TEST_CASE("a cube on an incline slides if and only if its slope exceeds the friction") {
  for (const double excess : {-0.5, 0.5}) {  // degrees
    Model model = hull_model(0.3, 1e5);
    const double slope = std::atan(0.3) + excess * pi / 180;
    model.motion.gravity = Vec3(std::sin(slope), 0, -std::cos(slope));
    State s;
    add_body(s, unit_cube(), Vec3(0, 0, 0.5 - 1e-5 * std::cos(slope)), Quat::Identity());
    add_floor(s);
    set_damping(model, 0.1);
    Team team(1);
    prepare(model, s, team);
    run_for(model, s, 2, team);
    const double way = s.grains.motion[0].position.x();
    if (excess < 0)
      CHECK(way < 2e-4);  // leans on its spring: sin(slope) / (shear_ratio c)
    else
      CHECK(way > 5e-3);
  }
}

TEST_CASE("a bounce off periodic images, threads: the same bits") {
  const auto run = [&](int threads) {
    Team team(threads);
    const Tessellation cells = voronoi_packing(periodic_space(Vec3::Constant(6)), 216, 2, 3, team);
    Model model = hull_model(0.4, 1e4);
    State s;
    s.boundary.cell.vectors = 6 * Mat3::Identity();
    for (std::size_t i = 0; i < cells.body.size(); ++i) {
      Polyhedron body = cells.body[i];
      const Vec3 centre = moments_of(body).centre;
      place(body, Mat3::Identity(), -centre);
      Vec3 v;
      for (int k = 0; k < 3; ++k) v[k] = 0.05 * random_normal(8, i, Purpose::turn, static_cast<std::uint64_t>(k));
      add_body(s, body, centre, Quat::Identity(), v);
    }
    prepare(model, s, team);
    const Vec3 before = momentum(s.grains);
    run_for(model, s, 0.3, team);
    const double balance = energy_error(s.ledger, stored_energy(model, s));
    CHECK(std::abs(balance) < 0.01);
    CHECK(s.ledger.friction > 0);
    CHECK((momentum(s.grains) - before).norm() < 1e-12);
    return s;
  };
  const State a = run(1), b = run(2);
  for (std::size_t i = 0; i < a.grains.size(); ++i) CHECK(a.grains.motion[i].position == b.grains.motion[i].position);
}
