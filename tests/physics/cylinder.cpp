// SPDX-License-Identifier: LGPL-3.0-or-later
// Cylinders, gradings by mass, and grains that resist motion by more than their solid.
#include "dem/fracture/apollonian.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/crushing.hpp"
#include "dem/rve/grading.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "tests/physics/crushable.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 1e-3;

/// About an axis through (1, 2, 0) cm along z, between two plates.
void add_cylinder(State& s, double radius, double height) {
  for (const int side : {0, 1})
    s.boundary.walls.push_back(
        {.point = Vec3(0, 0, side ? height : 0), .shape = PlaneWall{Vec3(0, 0, side ? -1 : 1)}, .material = 1});
  s.boundary.walls.push_back(
      {.point = Vec3(0.01, 0.02, 0), .shape = CylinderWall{Vec3::UnitZ(), radius}, .material = 1});
}

}  // namespace

TEST_CASE("a cylinder pushes towards its axis with the force of the overlap, whatever the angle") {
  const Model model = model_of(solid(7.8e9, 0.3, 2650));
  const double radius = 0.01, overlap = 1e-6;
  for (int k = 0; k < 11; ++k) {
    State s;
    add_cylinder(s, radius, 0.02);
    const Vec3 out(std::cos(0.6 * k), std::sin(0.6 * k), 0);
    add(s, PolyEllipsoid::sphere(R), Vec3(0.01, 0.02, 0.01) + (radius - R + overlap) * out, 2650);
    Team team(1);
    prepare(model, s, team);
    const double force = 4.0 / 3 * reduced_modulus(model.pairs[1]) * std::sqrt(R) * std::pow(overlap, 1.5);
    CHECK((s.grains.force[0] + force * out).norm() < 1e-6 * force);
    CHECK(s.boundary.walls[2].distance(s.grains.motion[0].position) == Approx(R - overlap).epsilon(1e-9));
  }
}

TEST_CASE("a ball that bounces in a smooth cylinder keeps its energy, and its angular momentum about the axis") {
  Model model = model_of(solid(7.8e9, 0.3, 2650));
  model.numerics.safety = 0.02;  // an impact in some hundred steps
  State s;
  add_cylinder(s, 0.01, 0.02);
  add(s, PolyEllipsoid::sphere(R), Vec3(0.015, 0.021, 0.01), 2650, Vec3(3, 1.5, 1));
  Team team(1);
  prepare(model, s, team);
  const auto about_axis = [&] {
    return (s.grains.motion[0].position - Vec3(0.01, 0.02, 0)).cross(s.grains.motion[0].velocity).z();
  };
  const double before = about_axis(), energy = stored_energy(model, s);
  run_for(model, s, 0.05, team);  // some ten bounces
  CHECK(about_axis() == Approx(before).epsilon(1e-9));
  CHECK(stored_energy(model, s) == Approx(energy).epsilon(1e-3));
}

TEST_CASE("volume, axial and radial stress of a sample in a cylinder") {
  const Model model = model_of(solid(7.8e9, 0.3, 2650));
  const double radius = 0.01, height = 2 * R - 2e-6, overlap = 1e-6;
  State s;
  add_cylinder(s, radius, height);
  const int n = 12;
  for (int k = 0; k < n; ++k) {
    const Vec3 out(std::cos(2 * pi * k / n), std::sin(2 * pi * k / n), 0);
    add(s, PolyEllipsoid::sphere(R), Vec3(0.01, 0.02, 0.5 * height) + (radius - R + overlap) * out, 2650);
  }
  Team team(1);
  prepare(model, s, team);
  CHECK(bulk_volume(s.boundary) == Approx(pi * radius * radius * height).epsilon(1e-12));
  const double force = 4.0 / 3 * reduced_modulus(model.pairs[1]) * std::sqrt(R) * std::pow(overlap, 1.5);
  const Measurement m = measure(model, s);
  CHECK(m.wall_stress(2, 2) == Approx(-n * force / (pi * radius * radius)).epsilon(1e-6));
  for (const int k : {0, 1})
    CHECK(m.wall_stress(k, k) == Approx(-n * force / (2 * pi * radius * height)).epsilon(1e-6));
  // Love-Weber says the same: arms of R across, and the radial one of radius - R more is held by nothing here.
  CHECK(m.stress(2, 2) == Approx(m.wall_stress(2, 2)).epsilon(1e-2));
}

TEST_CASE("a random packing in a cylinder fills it to the fraction, and all of it is inside") {
  const Vec3 box(0.02, 0.02, 0.015);
  const RadiusDistribution radius{"uniform", 1e-3, 0, 0.8e-3, 1.2e-3};
  Team team(1);
  const Packing p = random_packing(box, radius, 0.55, 0, Container::cylinder, 3, team, {});
  double solid = 0;
  for (const Sphere& s : p.spheres) {
    solid += 4 * pi / 3 * std::pow(s.radius, 3);
    const double away = std::hypot(s.position[0] - 0.01, s.position[1] - 0.01);
    CHECK(away + s.radius < 0.01 * (1 + 1e-3));
    CHECK(s.position[2] - s.radius > -1e-3 * s.radius);
    CHECK(s.position[2] + s.radius < box[2] + 1e-3 * s.radius);
  }
  CHECK(solid == Approx(0.55 * pi / 4 * box.prod()).epsilon(1e-9));
  CHECK(p.worst_overlap < 1e-6);
}

TEST_CASE(
    "grains that do not meet lie evenly over a cylinder's disc, and there are as many as come nearest to the "
    "fraction") {
  const Vec3 box(0.02, 0.02, 0.015);
  const double r = 1e-4, each = 4 * pi / 3 * r * r * r / (pi / 4 * box.prod());
  Team team(1);
  for (const double grains : {1500.3, 1500.7}) {
    const Packing p = random_packing(box, {"constant", r, 0, 0, 0}, grains * each, 0, Container::cylinder, 3, team, {});
    CHECK(static_cast<double>(p.spheres.size()) == std::round(grains));
    CHECK(std::pow(p.spheres[0].radius / r, 3) == Approx(grains / std::round(grains)).epsilon(1e-9));
    double sum = 0;  // of the area within each: even from 0 to 1, but for what the wall pushes in
    for (const Sphere& s : p.spheres) sum += std::pow(std::hypot(s.position[0] - 0.01, s.position[1] - 0.01) / 0.01, 2);
    const double n = static_cast<double>(p.spheres.size());
    CHECK(sum / n == Approx(0.5).margin(3 / std::sqrt(12 * n) + r / 0.01));
  }
}

TEST_CASE("a sample in a cylinder is loaded by a stress that rises: its lid follows") {
  Model model = model_of(solid(0.5e9, 0.3, 2650, 0.3));
  model.materials[0].damping = 0.3;
  make_pair_laws(model);
  State s;
  const Vec3 box(0.02, 0.02, 0.012);
  Team team(1);
  for (const Sphere& ball :
       random_packing(box, {"uniform", 1.2e-3, 0, 1e-3, 1.4e-3}, 0.56, 0, Container::cylinder, 3, team, {}).spheres)
    add(s, PolyEllipsoid::sphere(ball.radius), ball.position + Vec3(0, 0.01, 0), 2650);
  add_cylinder(s, 0.01, box[2]);
  prepare(model, s, team);
  Loading loading;
  loading.driven = true;
  const double rate = 1e9;
  loading.axes[2] = {.stress = 0, .max_rate = 100, .stress_rate = -rate};
  begin_loading(model, s, loading);
  load(model, s, loading, 0.004, team, {});
  const double wanted = rate * s.time;
  CHECK(-measure(model, s).wall_stress(2, 2) == Approx(wanted).epsilon(0.1));
  CHECK(measure(model, s).wall_stress(0, 0) < -0.1 * wanted);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 5e-3);
}

TEST_CASE("gradings by mass: what is drawn by number passes the sieves as asked") {
  const std::uint64_t n = 60000;
  RadiusDistribution sieve{.kind = "sieve"};
  sieve.sieve = {{0.5e-3, 0}, {1e-3, 0.35}, {1.5e-3, 0.35}, {2e-3, 1}};
  const RadiusDistribution wide{.kind = "log-normal", .min = 0.1e-3, .max = 10e-3, .median = 1e-3, .spread = 0.3};
  for (const RadiusDistribution* d : std::initializer_list<const RadiusDistribution*>{&sieve, &wide}) {
    std::vector<double> r;
    double cubes = 0;
    for (std::uint64_t i = 0; i < n; ++i) {
      r.push_back(draw_radius(*d, 3, i));
      cubes += std::pow(r.back(), 3);
    }
    const auto passing = [&](double size) {
      double sum = 0;
      for (const double x : r) sum += x < size ? x * x * x : 0;
      return sum / cubes;
    };
    // Error of a sum of cubes over n draws: some 3 / sqrt(n) of it.
    const double error = 0.02;
    CHECK(cubes / static_cast<double>(n) == Approx(d->mean_cube()).epsilon(error));
    if (d == &sieve) {
      CHECK(passing(1e-3) == Approx(0.35).margin(error));
      CHECK(passing(1.49e-3) == Approx(0.35).margin(error));
      CHECK(passing(std::sqrt(0.5) * 1e-3) == Approx(0.175).margin(error));
      CHECK(*std::min_element(r.begin(), r.end()) >= 0.5e-3 * (1 - 1e-12));
      CHECK(*std::max_element(r.begin(), r.end()) <= 2e-3 * (1 + 1e-12));
    } else {
      CHECK(passing(1e-3) == Approx(0.5).margin(error));
      CHECK(passing(1e-3 * std::exp(0.3)) == Approx(0.8413).margin(error));
    }
  }
}

TEST_CASE("scaled inertia: one m / k for all sizes below, the solid as it is, and what births put in is booked") {
  Model model = model_of(crushable({300e6, pi / 9}, 0.3));
  model.numerics.scaled_below = 2 * R;
  CHECK(model.numerics.inertia_factor(2 * R) == 1);
  CHECK(model.numerics.inertia_factor(0.25 * R) == Approx(16));
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650, Vec3(3, 0, 0), Vec3(0, 200, 0));
  add(s, PolyEllipsoid::sphere(R), Vec3(0.1, 0, 0), 2650);
  Team team(1);
  prepare(model, s, team);
  CHECK(s.grains.solid_mass.empty());
  const double mass = total_mass(s.grains), energy = kinetic_energy(s.grains);
  const double volume = whole_solid(model, s);
  apply_breaks(model, s, {{0, {Mat3::Zero(), std::nullopt, Vec3::UnitZ()}}}, team);
  REQUIRE(s.grains.solid_mass.size() == s.grains.size());
  CHECK(std::abs(total_mass(s.grains) + s.ledger.fines.mass - mass) < 1e-12 * mass);
  CHECK(whole_solid(model, s) == Approx(volume).epsilon(1e-12));
  CHECK(s.grains.solid_mass[1] == s.grains.mass[1]);
  double sum = 0;
  for (std::size_t i = 0; i < s.grains.size(); ++i) {
    const double r = s.grains.extent[i].equivalent_radius;
    CHECK(s.grains.mass[i] / s.grains.solid_mass[i] == Approx(R * R / (r * r)).epsilon(1e-12));
    CHECK(s.grains.mass[i] / r == Approx(s.grains.mass[1] / R).epsilon(1e-12));
    if (i == 1) continue;
    sum += r / R;
  }
  // Fourteen balls at the mother's speed: 4.34 of her inertia moves with it; the solid's part is with the fines, too.
  CHECK(s.ledger.inertia == Approx(kinetic_energy(s.grains) + s.ledger.fines.kinetic - energy).epsilon(1e-12));
  CHECK(s.ledger.inertia > (sum - 1) * 0.5 * s.grains.mass[1] * 9);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-12);
}

TEST_CASE("scaled inertia: the time step of fragments is the mother's, without it a fifth") {
  double dt[2];
  for (const bool scaled : {false, true}) {
    Model model = model_of(crushable({300e6, pi / 9}, 0.3));
    if (scaled) model.numerics.scaled_below = 2 * R;
    State s;
    add(s, PolyEllipsoid::sphere(R), Vec3(0, 0, R - 1e-6), 2650);
    add(s, PolyEllipsoid::sphere(R), Vec3(0, 0, 3 * R - 2e-6), 2650);
    add_floor(s);
    Team team(1);
    prepare(model, s, team);
    apply_breaks(model, s, {{0, {Mat3::Zero(), std::nullopt, Vec3::UnitZ()}}}, team);
    s.next_estimate = s.steps;
    update_time_step(model, s);
    dt[scaled] = s.dt;
  }
  // Same contacts; m of the ball at the pole is r / R of the mother's instead of its cube.
  CHECK(dt[1] / dt[0] == Approx(1 / 0.3660254038).epsilon(1e-3));
}
