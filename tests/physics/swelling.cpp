// SPDX-License-Identifier: LGPL-3.0-or-later
// Balls that are born with all of their mother's mass and grow to its volume: rate, end, work, and when they wait.
#include "dem/fracture/swelling.hpp"

#include "dem/contact/forces.hpp"
#include "dem/fracture/apollonian.hpp"
#include "dem/io/archive.hpp"
#include "dem/rve/crushing.hpp"
#include "tests/physics/crushable.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 1e-3, density = 2650, youngs = 7.8e9;

Model swelling(double strength = 1e30, double safety = 0.3) {
  Material m = crushable({strength, pi / 9});
  m.fracture->splitter = Balls{true, true};
  Model model = model_of(m);
  model.numerics.safety = safety;
  return model;
}

/// Radius that its mass wants.
double whole() { return R / std::cbrt(kept_volume()); }

/// Adds a ball that is 1 / 0.534 times as dense as its material.
void add_ball(State& s, const Vec3& x, bool turns = true, const Vec3& spin = Vec3::Zero(), double radius = R) {
  set_grain(s.grains, s.grains.size(),
            {.shape = PolyEllipsoid::sphere(radius),
             .position = x,
             .spin = spin,
             .density = density / kept_volume(),
             .turns = turns});
}

void begin(const Model& model, State& s, Team& team) {
  prepare(model, s, team);
  std::fill(s.grains.generation.begin(), s.grains.generation.end(), std::uint8_t{1});
}

/// Two rigid plates, `half` from the middle.
void add_plates(State& s, double half) {
  for (const int side : {-1, 1}) {
    Wall wall;
    wall.material = 1;
    wall.shape = PlaneWall{Vec3(0, 0, -side)}, wall.point = Vec3(0, 0, side * half);
    s.boundary.walls.push_back(wall);
  }
}

/// For a number of growths of a ball of radius R; the time step follows each step, as runs let it.
void grow(const Model& model, State& s, double times, Team& team) {
  const double end = s.time + times * swelling_times * pi * std::sqrt(s.grains.mass[0] / (2 * R * youngs));
  const std::uint64_t least = s.steps + static_cast<std::uint64_t>(250 * times);  // light contacts: longer steps
  while (s.time < end || s.steps < least) {
    update_time_step(model, s);
    run_steps(model, s, 1, team);
  }
}

/// dr/dt = c sqrt(r): the step to `whole` in twenty contact times pi sqrt(m / (2 r E)).
double growth_constant() {
  const double mass = 4.0 / 3 * pi * R * R * R * density / kept_volume();
  return (whole() - R) * std::sqrt(2 * youngs) / (swelling_times * pi * std::sqrt(mass));
}

}  // namespace

TEST_CASE("a ball alone grows to the volume of its mass, in twenty contact times, and loses spin to its inertia") {
  const Model model = swelling();
  Team team(1);
  State s;
  const Vec3 spin(100, -200, 50);
  add_ball(s, Vec3::Zero(), true, spin);
  begin(model, s, team);
  const double mass = s.grains.mass[0], inertia = 0.4 * mass * R * R;
  const double whole_time = 2 * (std::sqrt(whole()) - std::sqrt(R)) / growth_constant();
  CHECK(whole_time == Approx(swelling_times * pi * std::sqrt(mass / (2 * R * youngs))).epsilon(0.06));
  s.dt = whole_time / 1000;
  run_steps(model, s, 500, team);
  const double half_way = std::pow(std::sqrt(R) + 0.25 * growth_constant() * whole_time, 2);
  CHECK(s.grains.motion[0].radius == Approx(half_way).epsilon(1e-4));
  run_steps(model, s, 510, team);
  CHECK(s.grains.extent[0].volume == Approx(mass / density).epsilon(1e-12));
  const double r = s.grains.motion[0].radius;
  run_steps(model, s, 10, team);
  CHECK(s.grains.motion[0].radius == r);
  CHECK(s.grains.mass[0] == mass);
  CHECK((s.grains.angular_momentum[0] - inertia * spin).norm() < 1e-12 * inertia * spin.norm());
  const double ratio = std::pow(R / r, 2);  // of the inertias
  CHECK((s.grains.motion[0].spin - ratio * spin).norm() < 1e-9 * spin.norm());
  const double lost = 0.5 * inertia * spin.squaredNorm() * (1 - ratio);
  CHECK(s.ledger.reshape == Approx(-lost).epsilon(1e-2));  // a product of ends over each step, not its integral
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-2);
}

TEST_CASE("a ball that does not turn still does not once it has grown") {
  const Model model = swelling();
  Team team(1);
  State s;
  add_ball(s, Vec3::Zero(), false);
  begin(model, s, team);
  run_steps(model, s, 20, team);
  REQUIRE(s.grains.motion[0].radius > R);
  CHECK(s.grains.motion[0].inverse_inertia == 0);
}

TEST_CASE("a ball that swells between plates puts in what its contacts then hold") {
  const Model model = swelling();
  Team team(1);
  State s;
  add_ball(s, Vec3::Zero());
  const double half = 1.002 * R;
  add_plates(s, half);
  begin(model, s, team);
  grow(model, s, 4, team);
  const double overlap = s.grains.motion[0].radius - half;  // it waits for each look at the pressure that it makes
  REQUIRE(overlap > 0.02 * R);
  const double birth = s.contacts.contact.radius[0];
  CHECK(birth == Approx(R).epsilon(0.01));
  const double held = 2 * 8.0 / 15 * reduced_modulus(model.pairs[1]) * std::sqrt(birth) * std::pow(overlap, 2.5);
  CHECK(elastic_energy(model.law, s.contacts) == Approx(held).epsilon(1e-6));
  CHECK(s.ledger.reshape == Approx(held).epsilon(2e-3));
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 2e-3);
}

TEST_CASE("a ball that swells while friction stops its spin: the books close") {
  Model model = swelling(1e30, 0.05);
  model.materials[0].friction = 0.5;
  make_pair_laws(model);
  Team team(1);
  State s;
  add_ball(s, Vec3::Zero(), true, Vec3(2e4, 0, 0));
  add_plates(s, 0.98 * R);
  begin(model, s, team);
  const double spinning = kinetic_energy(s.grains);
  run_steps(model, s, 300, team);  // in one go: what a step closes is not what a run closes
  REQUIRE(s.grains.motion[0].radius > 1.001 * R);
  REQUIRE(s.ledger.friction > 0.2 * spinning);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 2e-3);
  CHECK(std::abs(s.ledger.unexplained) < 2e-3 * spinning);
}

TEST_CASE("a ball waits while it is pressed harder than the sample, and goes on once it is not") {
  const Model model = swelling();
  Team team(1);
  State s;
  add_ball(s, Vec3::Zero());
  add_ball(s, Vec3(10 * R, 0, 0), true, Vec3::Zero(), 0.5 * R);  // free between the plates, when it is grown, too
  add_plates(s, 0.999 * R);
  begin(model, s, team);
  const double force = s.contacts.touch[0].force.norm();
  const double alone = 2 * force / (4 * pi * R * R), all = alone / (1 + 0.125);
  CHECK(mean_pressure(model.law, s.grains, s.contacts, 0) == Approx(alone).epsilon(1e-12));
  CHECK(mean_pressure(model.law, s.grains, s.contacts, 1) == 0);
  CHECK(mean_pressure(model.law, s.grains, s.contacts) == Approx(all).epsilon(1e-12));
  grow(model, s, 1.5, team);
  CHECK(s.grains.motion[0].radius == R);
  CHECK(s.grains.motion[1].radius == Approx(0.5 * whole()).epsilon(1e-12));
  for (Wall& wall : s.boundary.walls) wall.point.z() *= 1.3;
  grow(model, s, 1.5, team);
  CHECK(s.grains.motion[0].radius == Approx(whole()).epsilon(1e-12));
}

TEST_CASE("the mean pressure of two balls is that of each") {
  const Model model = swelling();
  Team team(1);
  State s;
  for (const double x : {0.0, 1.998 * R}) add_ball(s, Vec3(x, 0, 0));
  begin(model, s, team);
  const double force = s.contacts.touch[0].force.norm(), pressure = force / (4 * pi * R * R);
  REQUIRE(force > 0);
  CHECK(mean_pressure(model.law, s.grains, s.contacts, 1) == Approx(pressure).epsilon(1e-12));
  CHECK(mean_pressure(model.law, s.grains, s.contacts) == Approx(pressure).epsilon(1e-12));
}

TEST_CASE("balls that swell across a gap wider than the list's skin meet, wherever the run was stopped meanwhile") {
  Model model = swelling(1e30, 0.03);
  model.numerics.skin = 0.05;
  Team team(1);
  State s;
  for (int k = 0; k < 4; ++k) add_ball(s, Vec3(2.2 * R * k, 0, 0));
  begin(model, s, team);
  run_steps(model, s, 10, team);
  REQUIRE(s.contacts.size() == 0);
  State again = state_of(bytes_of(s));
  const double radius = s.grains.motion[0].radius;
  CHECK(s.grains.motion[0].radius > R);
  for (State* run : {&s, &again}) grow(model, *run, 1.5, team);
  REQUIRE(s.grains.motion[0].radius > radius);
  CHECK(bytes_of(s) == bytes_of(again));
  // They part again, at what the work of their surfaces has given them.
  CHECK(s.ledger.reshape > 0);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.01);
  CHECK(momentum(s.grains).norm() < 1e-12 * s.grains.mass[0] * s.grains.motion[0].velocity.norm());
}

TEST_CASE("with swelling nothing is lost: a grain that breaks between plates has its volume back, or its density") {
  const Model model = swelling(300e6, 0.1);  // fourteen balls that fly apart are stiff: 0.3 errs by 13 %
  Team team(1);
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), density);
  add_plates(s, 0.9 * R);
  prepare(model, s, team);
  const double mass = total_mass(s.grains), volume = solid_volume(s.grains);
  apply_breaks(model, s, find_breaks(model, s, team), team);
  REQUIRE(s.grains.size() == 14);
  CHECK(solid_volume(s.grains) == Approx(kept_volume() * volume).epsilon(1e-9));
  CHECK(s.ledger.fines.mass == Approx(0).margin(1e-12 * mass));
  for (auto& strength : s.grains.strength) strength = 1e30;
  grow(model, s, 3, team);
  CHECK(total_mass(s.grains) == Approx(mass).epsilon(1e-12));
  CHECK(whole_solid(model, s) == Approx(volume).epsilon(1e-12));
  CHECK(solid_volume(s.grains) > 0.9 * volume);  // most fly freely from the plates
  CHECK(solid_volume(s.grains) < (1 + 1e-9) * volume);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.01);
}

TEST_CASE("a ball between two plates is at the pressure of one arm each") {
  const Model model = swelling();
  Team team(1);
  State s;
  add_ball(s, Vec3::Zero());
  add_plates(s, 0.999 * R);
  begin(model, s, team);
  const double force = s.contacts.touch[0].force.norm();
  REQUIRE(force > 0);
  REQUIRE(s.contacts.size() == 2);
  const double pressure = 2 * force * R / (4 * pi * R * R * R);
  CHECK(mean_pressure(model.law, s.grains, s.contacts) == Approx(pressure).epsilon(1e-12));
  CHECK(mean_pressure(model.law, s.grains, s.contacts, 0) == Approx(pressure).epsilon(1e-12));
}

TEST_CASE("a ball of scaled inertia swells to the volume of what is solid in it, at the pace of what resists") {
  State s;
  add_ball(s, Vec3::Zero());
  const double mass = s.grains.mass[0], stiffness = 2 * R * youngs;
  const auto grown = [&](double duration) { return *next_radius(s.grains, 0, density, stiffness, duration); };
  const double little = 1e-4 * swelling_times * pi * std::sqrt(mass / stiffness);
  const double plain = grown(little) - R;
  CHECK(plain == Approx(1e-4 * (1 - std::cbrt(kept_volume())) * whole()).epsilon(1e-9));
  s.grains.solid_mass = {mass}, s.grains.mass[0] = 9 * mass;
  CHECK(grown(little) - R == Approx(plain / 3).epsilon(1e-9));
  s.grains.motion[0].radius = s.grains.extent[0].equivalent_radius = (1 - 1e-6) * whole();
  CHECK(grown(1) == Approx(whole()).epsilon(1e-12));
  s.grains.extent[0].equivalent_radius = whole();
  CHECK_FALSE(next_radius(s.grains, 0, density, stiffness, 1).has_value());
}
