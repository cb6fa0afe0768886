// SPDX-License-Identifier: LGPL-3.0-or-later
// Explicit dynamics: wave speeds, stable step, energy, order, going on from a snapshot.
#include "fem/dynamics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/helpers.hpp"

namespace grus {  // headers of DOLFINx bring another `fem` into the global space

using fem::Kinematics;
using fem::Point;
using fem::test::plane;

namespace {

constexpr double E = 200e9, nu = 0.3, rho = 7800;

/// A bar along y, 1 m long, whose lower end moves at a constant speed from t = 0.
std::unique_ptr<fem::Problem> bar(Kinematics kinematics, bool confined, long cells, double radius, double speed,
                                  double duration) {
  auto low = plane("low", 1, 0, 1, speed * duration);
  low.history.points = {{0, 0}, {duration, 1}};
  std::vector<fem::BoundaryCondition> b{low, plane("axis", 0, 0, 0, 0)};
  if (confined) b.push_back(plane("side", 0, radius, 0, 0));
  return std::make_unique<fem::Problem>(MPI_COMM_WORLD, fem::BoxMesh{{radius, 1, 1}, {1, cells, 1}, true, {}},
                                        fem::Discretisation{1, 2, false, kinematics, 1}, b);
}

/// Mean axial strain of the points between two places.
double strain_between(const fem::Problem& p, double from, double to) {
  std::vector<std::uint8_t> some;
  for (std::size_t i = 0; i < p.owned_points(); ++i)
    some.push_back(p.point_position(i)[1] > from && p.point_position(i)[1] < to);
  return p.mean_strain(some)[1];
}

}  // namespace

TEST_CASE(
    "a step wave runs at the P-wave speed in a confined bar and at sqrt(E/rho) in a thin one, with strain v / c behind "
    "it") {
  const double speed = 1, confined_modulus = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  for (bool confined : {true, false}) {
    const double c = std::sqrt((confined ? confined_modulus : E) / rho), duration = 0.75 / c;
    const auto problem = bar(Kinematics::axisymmetric, confined, 200, 0.005, speed, duration);
    fem::Material m = fem::elastic_material(problem->owned_points(), E, nu);
    fem::DynamicsOptions o;
    o.duration = duration, o.linear_viscosity = 0.06;
    const auto result = fem::solve_dynamics(*problem, m, std::vector<double>(problem->owned_points(), rho), o,
                                            [](const fem::DynamicsReport&) { return true; });
    REQUIRE(result.finished);
    CHECK(-strain_between(*problem, 0.1, 0.6) == Approx(speed / c).epsilon(5e-3));
    CHECK(std::abs(strain_between(*problem, 0.85, 1)) < 1e-3 * speed / c);
    // Displacement is the speed times the time, all of it in the length that the wave has passed: its front is at c t.
    const double front = -strain_between(*problem, 0, 1) / (speed / c);
    CHECK(front == Approx(0.75).epsilon(5e-3));
    CHECK(std::abs(result.last.energy.error()) < 5e-3);
    // Half kinetic, half elastic: E = rho v^2 c t A / 2 each.
    CHECK(result.last.energy.kinetic == Approx(0.5 * rho * speed * speed * 0.75 * M_PI * 0.005 * 0.005)
                                            .epsilon(2e-2));  // the viscous front takes its part
  }
}

TEST_CASE("the stable step is that of the stiffest element, and beyond it the run is stopped as unstable") {
  const auto problem = bar(Kinematics::plane_strain, true, 20, 0.05, 1, 1e-3);
  const std::vector<double> density(problem->owned_points(), rho);
  fem::Material m = fem::elastic_material(problem->owned_points(), E, nu);
  fem::DynamicsOptions o;
  o.duration = 1e-6;
  REQUIRE(fem::solve_dynamics(*problem, m, density, o, [](const fem::DynamicsReport&) { return true; }).finished);
  const double c = std::sqrt(E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / rho),
               bound = fem::stable_step(*problem, density);
  // One square cell of side h: its stiffest mode is the dilation of both directions, omega^2 = 4 (lambda + mu + mu/..)
  // / (rho h^2) >= 4 c^2 / h^2.
  CHECK(bound <= 0.05 / c * (1 + 1e-9));
  CHECK(bound > 0.4 * 0.05 / c);
  for (double part : {0.98, 2.5}) {
    const auto again = bar(Kinematics::plane_strain, true, 20, 0.05, 1, 2e-3);
    fem::Material elastic = fem::elastic_material(again->owned_points(), E, nu);
    fem::DynamicsOptions fixed;
    fixed.duration = 2e-3, fixed.time_step = part * bound;
    const auto result =
        fem::solve_dynamics(*again, elastic, density, fixed, [](const fem::DynamicsReport&) { return true; });
    CHECK(result.finished == (part < 1));
    CHECK(result.failure.empty() == (part < 1));
  }
}

TEST_CASE("beyond the critical step the balance itself is what finds out; each of its terms is known on its own") {
  // A bar that moves so little that nothing turns inside out before its energy tells. Held at its sides, a chain of
  // elements: its critical step is h / c, 1.2 times that of a free element.
  const double speed = 1e-5;
  double step = 0;
  auto go = [&](double part, double viscosity, double limit) {
    const auto problem = bar(Kinematics::plane_strain, true, 20, 0.05, speed, 2e-3);
    const std::vector<double> density(problem->owned_points(), rho);
    fem::Material m = fem::elastic_material(problem->owned_points(), E, nu);
    fem::DynamicsOptions o;
    o.duration = 2e-3, o.linear_viscosity = viscosity, o.max_energy_error = limit;
    o.time_step = part * step;
    if (part == 0) o.duration = 1e-6;
    const auto result = fem::solve_dynamics(*problem, m, density, o, [](const fem::DynamicsReport&) { return true; });
    if (part == 0) step = fem::stable_step(*problem, density);
    return result;
  };
  REQUIRE(go(0, 0, 0.1).finished);
  for (const double part : {1.25, 1.5}) {
    const auto result = go(part, 0, 0.1);
    CHECK_FALSE(result.finished);
    INFO(result.failure << " k " << result.last.energy.kinetic << " i " << result.last.energy.internal << " x "
                        << result.last.energy.external);
    CHECK(result.failure.find("energy error") != std::string::npos);
    CHECK(result.last.energy.kinetic >= 0);
    CHECK(result.last.energy.internal >= 0);
  }
  const auto calm = go(0.5, 0.06, 0.1);
  REQUIRE(calm.finished);
  CHECK(calm.last.energy.viscous > 0);
  CHECK(std::abs(calm.last.energy.error()) < 0.02);
  CHECK(calm.last.energy.work == Approx(calm.last.energy.internal).epsilon(0.02));  // and so do forces and strains
}

TEST_CASE("bulk viscosity is a pressure: a block that is struck spreads to all its sides alike, and shears nowhere") {
  auto low = plane("low", 2, 0, 2, 1e-4);
  low.history.points = {{0, 0}, {1e-4, 1}};
  fem::Problem block(MPI_COMM_WORLD, fem::BoxMesh{{1, 1, 2}, {2, 2, 4}, true, {}},
                     fem::Discretisation{1, 2, false, Kinematics::solid, 1}, {low});
  fem::Material m = fem::elastic_material(block.owned_points(), E, 0);
  fem::DynamicsOptions o;
  o.duration = 1e-4, o.linear_viscosity = 0.5;
  REQUIRE(
      fem::solve_dynamics(block, m, std::vector<double>(block.owned_points(), rho), o, [](const fem::DynamicsReport&) {
        return true;
      }).finished);
  const fem::MacroFields fields = block.gather_fields();  // on rank 0
  std::array<double, 2> spread{};
  for (std::size_t n = 0; n < fields.nodes.size(); ++n)
    for (std::size_t k = 0; k < 2; ++k) spread[k] += fields.displacement[n][k] * (fields.nodes[n][k] - 0.5);
  CHECK(std::abs(spread[0] - spread[1]) <= 1e-9 * spread[0]);
  for (std::size_t n = 0; n < fields.nodes.size(); ++n)
    for (std::size_t k = 0; k < 2; ++k)  // the middle stays where it is, at any height
      if (fields.nodes[n][k] == 0.5) CHECK(std::abs(fields.displacement[n][k]) <= 1e-9 * spread[k]);
  for (std::size_t i = 0; i < block.owned_points(); ++i)  // without Poisson's ratio what is told is without viscosity
    for (std::size_t k = 0; k < 3; ++k) {
      const double strain = block.deformation()[9 * i + 4 * k] - 1;
      CHECK(std::abs(block.stress()[6 * i + k] - E * strain) < 1e-9 * E * 1e-4);
    }
}

TEST_CASE("energy balance and displacement converge with the square of the step") {
  // One end driven by half a sine: smooth, so that the time step alone decides.
  std::array<double, 3> energy{}, place{};
  int k = 0;
  for (double part : {0.8, 0.4, 0.2}) {
    auto low = plane("low", 1, 0, 1, 1e-3);
    for (int i = 0; i <= 400; ++i) low.history.points.push_back({i * 1e-6, std::pow(std::sin(M_PI * i / 400), 4)});
    fem::Problem problem(MPI_COMM_WORLD, {{0.05, 1, 1}, {1, 10, 1}, true, {}},
                         {1, 2, false, Kinematics::plane_strain, 1},
                         {low, plane("axis", 0, 0, 0, 0), plane("side", 0, 0.05, 0, 0)});
    fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
    fem::DynamicsOptions o;
    o.duration = 3e-4, o.time_step = part * 1e-5;
    const auto result = fem::solve_dynamics(problem, m, std::vector<double>(problem.owned_points(), rho), o,
                                            [](const fem::DynamicsReport&) { return true; });
    REQUIRE(result.finished);
    energy[static_cast<std::size_t>(k)] = std::abs(result.last.energy.error()),
    place[static_cast<std::size_t>(k++)] = problem.mean_strain()[1];
  }
  CHECK(std::log2((place[0] - place[1]) / (place[1] - place[2])) == Approx(2).margin(0.25));
  CHECK(energy[2] < energy[0]);
  CHECK(energy[2] < 1e-3);
}

TEST_CASE("a dynamic run goes on from a snapshot bit by bit, between two looks at tangents that have changed, too") {
  const bool yields = GENERATE(false, true);
  auto run = [&](double until, const fem::Snapshot& from, const fem::DynamicsReport& start, fem::Snapshot& state,
                 std::string& material, bool load) {
    const auto problem = bar(Kinematics::axisymmetric, false, 30, 0.01, 2, 1e-4);
    fem::Material m = yields ? fem::j2_material(problem->owned_points(), E, nu, 20e6, 0.1 * E)
                             : fem::elastic_material(problem->owned_points(), E, nu);
    if (load) problem->restore(from), m.load(material);
    fem::DynamicsOptions o;
    o.estimate_every = 4, o.duration = 1e-4, o.output_interval = 5e-5, o.linear_viscosity = 0.1;
    const auto result = fem::solve_dynamics(
        *problem, m, std::vector<double>(problem->owned_points(), rho), o,
        [&](const fem::DynamicsReport& r) { return r.time < until; }, start);
    state = problem->snapshot(), material = m.save();
    return result.last;
  };
  int ranks;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  if (ranks > 1) return;  // a snapshot lives on rank 0
  fem::Snapshot whole, half, rest;
  std::string material, unused;
  run(1, {}, {}, whole, unused, false);
  const auto middle = run(4e-5, {}, {}, half, material, false);
  CHECK(middle.time < 6e-5);
  run(1, half, middle, rest, material, true);
  CHECK((rest.values == whole.values));
  CHECK((rest.at_nodes == std::vector<std::string>{"last internal", "last load", "now internal", "velocity"}));
}

}  // namespace grus
