// SPDX-License-Identifier: LGPL-3.0-or-later
// Runs of crushable spheres: linear contacts by modulus, grains that do not turn, and where breaking is hard.
#include "dem/rve/crushing.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/real_time.hpp"
#include "dem/rve/rve.hpp"
#include "tests/physics/crushable.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 1e-3;

}  // namespace

TEST_CASE("linear by modulus: k = 2 K D1 D2 / (D1 + D2), against a wall 2 K D") {
  Material m = solid(60e9, 0.2, 2650);
  const double K = 300e6;
  m.contact = LinearSpring::Of{.modulus = K, .shear_ratio = 0.25};
  Model model = model_of(m);
  model.law = LinearSpring{};
  make_pair_laws(model);
  State s;
  const double d1 = 2e-3, d2 = 3e-3, overlap = 1e-6;
  add(s, PolyEllipsoid::sphere(0.5 * d1), Vec3(0, 0, 0.5 * d1 - overlap), 2650);
  add(s, PolyEllipsoid::sphere(0.5 * d2), Vec3(0, 0, d1 + 0.5 * d2 - 2 * overlap), 2650);
  add_floor(s);
  Team team(1);
  prepare(model, s, team);
  REQUIRE(s.contacts.size() == 2);
  CHECK(s.contacts.touch[0].force.z() == Approx(2 * K * d1 * d2 / (d1 + d2) * overlap).epsilon(1e-9));
  CHECK(s.contacts.touch[1].force.z() == Approx(-2 * K * d1 * overlap).epsilon(1e-9));
}

TEST_CASE("grains that do not turn slide by Coulomb's law with no spin, and their books close") {
  Model model = model_of(solid(7.8e9, 0.3, 2650, 0.4));
  model.motion.gravity = Vec3(0, 0, -9.81);
  for (const bool turns : {false, true}) {
    State s;
    add_floor(s);
    const double sag = std::pow(
        4.0 / 3 * pi * R * R * R * 2650 * 9.81 / (4.0 / 3 * reduced_modulus(model.pairs[1]) * std::sqrt(R)), 2.0 / 3);
    set_grain(s.grains, 0,
              {.shape = PolyEllipsoid::sphere(R),
               .position = Vec3(0, 0, R - sag),
               .velocity = Vec3(0.2, 0, 0),
               .density = 2650,
               .turns = turns});
    Team team(1);
    prepare(model, s, team);
    run_for(model, s, 0.01, team);
    const double slid = 0.2 - 0.4 * 9.81 * 0.01;  // all the way: a free one rolls after 2/7 v / (mu g) = 15 ms
    CHECK(s.grains.motion[0].velocity.x() == Approx(slid).epsilon(2e-3));
    if (turns) {
      CHECK(s.grains.motion[0].spin.y() == Approx(2.5 * 0.4 * 9.81 * 0.01 / R).epsilon(5e-3));
    } else {
      CHECK(s.grains.motion[0].spin == Vec3::Zero());
      CHECK(s.grains.angular_momentum[0] == Vec3::Zero());
      CHECK(s.ledger.friction == Approx(0.5 * s.grains.mass[0] * (0.04 - slid * slid)).epsilon(5e-3));
    }
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-3);
  }
}

TEST_CASE("what a row says of a crushed sample: how deep its contacts are, and its lateral stress") {
  const Model model = model_of(solid(7.8e9, 0.3, 2650));
  State s;
  add_floor(s);
  // Overlaps, of the smaller radius: 0.05 with the floor, 0.2 and 0.4 with balls; one touches nothing.
  add(s, PolyEllipsoid::sphere(R), Vec3(0, 0, 0.95 * R), 2650);
  add(s, PolyEllipsoid::sphere(0.5 * R), Vec3(1.4 * R, 0, 0.95 * R), 2650);
  add(s, PolyEllipsoid::sphere(2 * R), R * Vec3(0, std::sqrt(2.6 * 2.6 - 2.05 * 2.05), 3), 2650);
  add(s, PolyEllipsoid::sphere(R), Vec3(20 * R, 0, 5 * R), 2650);
  Team team(1);
  prepare(model, s, team);
  CHECK(share_deeper(s, 0.01) == 1);
  CHECK(share_deeper(s, 0.1) == Approx(2.0 / 3));
  CHECK(share_deeper(s, 0.3) == Approx(1.0 / 3));
  CHECK(share_deeper(s, 0.5) == 0);
  CHECK(lateral_ratio(Vec3(-2e6, -1e6, -5e6), 2) == Approx(0.3));
  CHECK(lateral_ratio(Vec3(-2e6, -1e6, -5e6), 0) == Approx(1.5));
  CHECK(std::isnan(lateral_ratio(Vec3(-1, -1, 0), 2)));
}

TEST_CASE("all grains of a cell break in one test, at its seam and in its corner: the books close, and it goes on") {
  Material material = crushable({1.0, pi / 9}, 0.4);  // bears nothing
  material.restitution = 0.5;
  material.fracture->limit = {0.6 * R, 255, 0};  // once
  const Model model = model_of(material);
  State s;
  const double pitch = 2 * R * (1 - 1e-3);
  const int n = 3;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) add(s, PolyEllipsoid::sphere(R), pitch * Vec3(x, y, z), 2650);  // on the seam
  s.boundary.cell.vectors = n * pitch * Mat3::Identity();
  Team team(1);
  prepare(model, s, team);
  const double mass = total_mass(s.grains);
  run_steps(model, s, 1, team);
  s.next_test = s.steps + 1;
  run_for(model, s, 300 * s.dt, team);
  CHECK(s.ledger.breakages == n * n * n);
  CHECK(s.grains.size() == 14 * n * n * n);
  CHECK(std::abs(total_mass(s.grains) + s.ledger.fines.mass - mass) < 1e-12 * mass);
  CHECK(s.ledger.fines.volume == Approx(s.ledger.fines.mass / 2650).epsilon(1e-12));  // of all events together
  const double speed = std::sqrt(2 * kinetic_energy(s.grains) / mass);
  CHECK((momentum(s.grains) + s.ledger.fines.momentum).norm() < 1e-9 * mass * speed);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.01);
}

TEST_CASE("a cell that is carried in time tells the steps, the work and the breakages of that piece alone") {
  Model model = model_of(crushable({2e6, pi / 9}, 0.3));
  model.materials.push_back(crushable({8e6, pi / 9}, 0.3));
  for (Material& m : model.materials) m.fracture->limit = {0.6 * R, 255, 0};  // once
  make_pair_laws(model);
  Team team(1);
  State s;
  for (int k = 0; k < 27; ++k) {
    add(s, PolyEllipsoid::sphere(R), 2 * R * Vec3(k % 3, k / 3 % 3, k / 9), 2650);
    s.grains.material.back() = k % 9 != 4;  // most are four times as strong
  }
  s.boundary.cell.vectors = 6 * R * Mat3::Identity();
  prepare(model, s, team);
  std::size_t told = 0;
  std::uint64_t steps = 0;
  for (int k = 0; k < 3; ++k) {
    const std::size_t before = s.ledger.breakages;
    CHECK(before == (k == 0 ? 0 : 3));  // the first piece breaks the weak ones
    const Response r = respond_in_time(model, s, Vec3(0.999, 0.998, 0.997).asDiagonal(), 2e-5, false, team);
    CHECK(r.breakages == s.ledger.breakages - before);
    CHECK(r.work == s.ledger.work);
    CHECK((r.stable && r.steps > 0 && r.tangent.isZero()));
    told += r.breakages, steps += r.steps;
  }
  CHECK((told == s.ledger.breakages && steps == s.steps));
  CHECK(respond_in_time(model, s, Mat3::Identity(), 0, true, team).breakages == 0);
}

TEST_CASE("a hold that asks for nothing else goes on for a window in which no grain breaks") {
  for (const bool breaks : {false, true}) {
    Material material = crushable({breaks ? 1.0 : 1e12, pi / 9}, 0.4);
    material.fracture->limit = {0.6 * R, 255, 0};  // once
    const Model model = model_of(material);
    State s;
    const double pitch = 2 * R * (1 - 1e-3);
    for (int k = 0; k < 27; ++k) add(s, PolyEllipsoid::sphere(R), pitch * Vec3(k % 3, k / 3 % 3, k / 9), 2650);
    s.boundary.cell.vectors = 3 * pitch * Mat3::Identity();
    Team team(1);
    prepare(model, s, team);
    run_steps(model, s, 1, team);
    s.next_test = s.steps + 1;
    QuasiStatic q;
    q.unbalanced_force = q.stress_change = 1e9, q.window = 40;
    const Response r = hold(model, q, s, team);
    CHECK(r.stable);
    CHECK(s.ledger.breakages == (breaks ? 27 : 0));
    CHECK((breaks ? r.hold_steps > 40 : r.hold_steps == 40));
  }
}

TEST_CASE("a grain that breaks in a corner between walls, a hundred times larger than its neighbour") {
  const Model model = model_of(crushable({300e6, pi / 9}, 0.4));
  State s;
  add_box(s, 2 * R);
  add(s, PolyEllipsoid::sphere(0.995 * R), Vec3::Constant(0.9949 * R), 2650);
  add(s, PolyEllipsoid::sphere(0.00995 * R), Vec3(1.99 * R - 1e-3 * R, 0.9949 * R, 0.9949 * R), 2650);
  Team team(1);
  prepare(model, s, team);
  const double mass = total_mass(s.grains);
  apply_breaks(model, s, {{0, {Mat3::Zero(), std::nullopt, Vec3(1, 1, 1).normalized()}}}, team);
  REQUIRE(s.grains.size() == 15);
  run_for(model, s, 200 * s.dt, team);
  for (const auto& m : s.grains.motion)
    for (const Wall& w : s.boundary.walls) CHECK(w.distance(m.position) > 0);
  CHECK(std::abs(total_mass(s.grains) + s.ledger.fines.mass - mass) < 1e-12 * mass);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.01);
}
