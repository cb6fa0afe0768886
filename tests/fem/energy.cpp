// SPDX-License-Identifier: LGPL-3.0-or-later
// The energy balance of increments: work of loads and reactions against what the materials hold and have spent, by
// closed forms, in three dimensions, plane strain and axial symmetry.
#include "coupling/rve_material.hpp"
#include "fem/explicit_statics.hpp"
#include "fem/statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/fem/sand.hpp"

namespace grus {  // DOLFINx has a namespace fem, too
namespace {

using fem::Kinematics;
using fem::MacroEnergy;
using fem::Point;
using fem::test::plane;

constexpr double E = 1e8, nu = 0.25, pi = 3.14159265358979323846;
constexpr double M = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu));  // of a body that cannot move sideways

fem::BoundaryCondition pressed(std::string name, std::size_t axis, double place, double by) {
  fem::BoundaryCondition b;
  b.name = std::move(name), b.pressure = by;
  b.where = [=](const Point& x) { return std::abs(x[axis] - place) < 1e-9; };
  return b;
}

/// Energies after each increment.
std::vector<MacroEnergy> increments(fem::Problem& problem, fem::Material m, int number, double tolerance = 1e-11) {
  fem::StaticsOptions o;
  o.increments = number, o.tolerance = tolerance, o.displacement_tolerance = 1e-6;
  std::vector<MacroEnergy> all;
  const auto note = [&](const fem::IncrementReport& r) { return all.push_back(r.energy), true; };
  const auto result = fem::solve_statics(problem, m, o, note);
  INFO(result.failure);
  REQUIRE(result.converged);
  return all;
}

/// A block (thickness 0.3) or a disc of unit radius and height 2 that only its top can press, rollers elsewhere.
fem::Problem confined(Kinematics k, const fem::BoundaryCondition& top) {
  const std::size_t up = k == Kinematics::solid ? 2 : 1;
  const Point size = up == 2 ? Point{1, 1, 2} : Point{1, 2, 1};
  std::vector<fem::BoundaryCondition> all{top, plane("base", up, 0, up, 0), plane("x0", 0, 0, 0, 0),
                                          plane("x1", 0, 1, 0, 0)};
  if (up == 2) all.push_back(plane("y0", 1, 0, 1, 0)), all.push_back(plane("y1", 1, 1, 1, 0));
  return fem::Problem(MPI_COMM_WORLD, fem::BoxMesh{size, {2, 2, 2}, true, {}}, {1, 2, true, k, 0.3}, all);
}

double volume(Kinematics k) { return k == Kinematics::solid ? 2 : k == Kinematics::plane_strain ? 0.6 : 2 * pi; }

}  // namespace

TEST_CASE("a pressure on a confined elastic body does p^2 V / 2 M, all of it held, however it comes and is solved") {
  for (const auto k : {Kinematics::solid, Kinematics::plane_strain, Kinematics::axisymmetric}) {
    // Sides do not move, so nominal stress is M times the strain and the body's energy quadratic: the trapezoid of the
    // work is exact. A pressure that is there from the start counts as set on within the first increment.
    const double p = 1e6, done = p * p * volume(k) / (2 * M);
    for (const bool at_once : {false, true}) {
      fem::BoundaryCondition top = pressed("top", k == Kinematics::solid ? 2 : 1, 2, p);
      if (at_once) top.history.points = {{0, 1}};
      fem::Problem problem = confined(k, top);
      const auto all = increments(problem, fem::elastic_material(problem.owned_points(), E, nu), 3);
      for (std::size_t n = 0; n < 3; ++n) {
        const double so_far = at_once ? done : done * std::pow((static_cast<double>(n) + 1) / 3, 2);
        CHECK(all[n].external == Approx(so_far).epsilon(1e-7));
        CHECK(all[n].internal == Approx(so_far).epsilon(1e-7));
        CHECK(all[n].work == Approx(so_far).epsilon(1e-7));
        CHECK(std::abs(all[n].error()) < 1e-7);
      }
    }
    // Prescribed, the reaction does the same work; explicit steps book it as well, with what their damping takes.
    const std::size_t up = k == Kinematics::solid ? 2 : 1;
    fem::Problem driven = confined(k, plane("top", up, 2, up, -2 * p / M));
    const auto all = increments(driven, fem::elastic_material(driven.owned_points(), E, nu), 3);
    CHECK(all.back().external == Approx(done).epsilon(1e-7));
    CHECK(all.back().internal == Approx(done).epsilon(1e-7));
    fem::Problem stepped = confined(k, pressed("top", up, 2, p));
    fem::Material m = fem::elastic_material(stepped.owned_points(), E, nu);
    const auto last = fem::solve_explicit_statics(stepped, m, {}, [](const auto&) { return true; }).last;
    CHECK(last.energy.internal == Approx(done).epsilon(0.04));  // twice the balance that is kept
    CHECK(last.energy.external - last.energy.damped == Approx(last.energy.internal).epsilon(2e-3));
    CHECK(std::abs(last.energy.error()) < 1e-3);
  }
}

TEST_CASE(
    "a pressure on a body at once does p^2 V / M: half of it is held, half damped, before the first row of a run") {
  for (const auto k : {Kinematics::solid, Kinematics::plane_strain, Kinematics::axisymmetric}) {
    const std::size_t up = k == Kinematics::solid ? 2 : 1;
    fem::BoundaryCondition top = pressed("top", up, 2, 1e6);
    top.history.points = {{0, 1}};
    fem::Problem problem = confined(k, top);
    fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
    const double done = 1e12 * volume(k) / M;
    std::vector<MacroEnergy> rows;
    fem::ExplicitStaticsOptions o;
    o.balance = 1e-3;
    REQUIRE(fem::solve_explicit_statics(problem, m, o, [&](const auto& r) {
              return rows.push_back(r.energy), true;
            }).finished);
    for (const MacroEnergy& e : rows) {
      CHECK(e.external == Approx(done).epsilon(2e-3));  // twice the balance
      CHECK(e.internal == Approx(done / 2).epsilon(4e-3));
      CHECK(e.damped == Approx(done / 2).epsilon(4e-3));
      CHECK(std::abs(e.error()) < 2e-3);
    }
  }
}

TEST_CASE("a metal bar that yields and is let go: work is what it held and what it spent, by the bilinear law") {
  const double young = 200e9, yield = 25e6, H = 10e9, most = 5e-4;
  const double stress = yield + young * H / (young + H) * (most - yield / young), plastic = most - stress / young;
  fem::BoundaryCondition top = plane("top", 2, 1, 2, most);
  top.history.points = {{0, 0}, {0.5, 1}, {1, plastic / most}};  // the stress is gone there
  fem::Problem bar(MPI_COMM_WORLD, fem::BoxMesh{{1, 1, 1}, {1, 1, 1}, true, {}}, {1, 2, true, Kinematics::solid, 1},
                   {top, plane("base", 2, 0, 2, 0), plane("x0", 0, 0, 0, 0), plane("y0", 1, 0, 1, 0)});
  const int number = 40;
  const auto all = increments(bar, fem::j2_material(bar.owned_points(), young, 0.3, yield, H), number, 1e-9);
  const double loaded = 0.5 * yield * yield / young + 0.5 * (yield + stress) * (most - yield / young);
  const double spent = yield * plastic + 0.5 * H * plastic * plastic, strains = 2 * most;  // areas change by those
  const MacroEnergy &up = all[number / 2 - 1], &back = all.back();
  CHECK(up.internal == Approx(loaded).epsilon(strains));
  CHECK(back.internal == Approx(spent).epsilon(strains));
  // The trapezoid misses no more than the corner that the yield point cuts off within its increment.
  const double part = 2 * most / number, corner = 0.125 * young * part * part;
  for (const MacroEnergy& e : all) CHECK(std::abs(e.external - e.internal) < 1.1 * corner);
  CHECK(std::abs(back.error()) < 1.1 * corner / loaded);
  CHECK(up.internal - back.internal == Approx(0.5 * stress * stress / young).epsilon(0.1));  // what it gave back
}

TEST_CASE("a pressure that follows an even compression does the work of p dV, the trapezoid of it to the digit") {
  // Stress 3 K (stretch - 1) on faces that shrink with the stretch's square.
  const double K = E / (3 * (1 - 2 * nu)), p = 0.03 * 3 * K;
  fem::Problem problem(MPI_COMM_WORLD, fem::BoxMesh{{1, 1, 1}, {2, 2, 2}, true, {}}, {1, 2, true},
                       {plane("x0", 0, 0, 0, 0), plane("y0", 1, 0, 1, 0), plane("z0", 2, 0, 2, 0),
                        pressed("x1", 0, 1, p), pressed("y1", 1, 1, p), pressed("z1", 2, 1, p)});
  constexpr int number = 6;
  const auto all = increments(problem, fem::elastic_material(problem.owned_points(), E, nu), number);
  double work = 0, before = 1, force = 0;
  for (int n = 1; n <= number; ++n) {
    const double now = 1 - 0.03 * n / number, next = p * n / number * now * now;
    work += 3 * 0.5 * (force + next) * (before - now);
    before = now, force = next;
    const auto& e = all[static_cast<std::size_t>(n - 1)];
    const double held = 4.5 * K * (1 - now) * (1 - now);
    CHECK(e.external == Approx(work).epsilon(1e-7));
    CHECK(e.internal == Approx(held).epsilon(1e-7));
    // What is left goes with the strain e: stored energy is right to first order (4/3 e), the trapezoid cuts chords
    // (2/3 e / n^2).
    CHECK(e.error() == Approx(-(4.0 / 3 + 2.0 / 3 / (n * n)) * (1 - now)).epsilon(0.03));
  }
  const double exact = 9 * K * ((1 - std::pow(before, 3)) / 3 - (1 - std::pow(before, 4)) / 4);
  CHECK(work == Approx(exact).epsilon(1.1 * 2.0 / 3 * 0.03 / (number * number)));
}

TEST_CASE(
    "a J2 bar: work is what is held and what plastic strain has spent; a kink within an increment costs its corner") {
  const double yield = 1e5, H = 5e6, Et = E * H / (E + H), elastic = yield / E, top = 4 * elastic;
  for (const int number : {4, 5}) {  // the first yields at the end of an increment, the second within one
    fem::Problem problem(
        MPI_COMM_WORLD, fem::BoxMesh{{1, 1, 1}, {2, 2, 2}, true, {}}, {1, 2, false},
        {plane("x0", 0, 0, 0, 0), plane("y0", 1, 0, 1, 0), plane("z0", 2, 0, 2, 0), plane("top", 2, 1, 2, top)});
    const auto all = increments(problem, fem::j2_material(problem.owned_points(), E, nu, yield, H), number);
    const double stress = yield + Et * (top - elastic), plastic = top - stress / E;
    const double held = stress * stress / (2 * E), spent = (yield + 0.5 * H * plastic) * plastic;
    const double done = 0.5 * yield * elastic + (yield + 0.5 * Et * (top - elastic)) * (top - elastic);
    REQUIRE(held + spent == Approx(done).epsilon(1e-12));
    CHECK(all.back().internal == Approx(done).epsilon(1e-7));
    const double corner = (E - Et) * std::pow(top / number, 2) / 8;  // of the largest triangle that a chord cuts off
    if (number == 4)
      CHECK(std::abs(all.back().external - done) < 1e-6 * done);
    else
      CHECK((all.back().external < done - 0.1 * corner && all.back().external > done - 1.001 * corner));
  }
}

TEST_CASE("a column under its own weight: weight does half of weight times settlement, and the column holds it") {
  const double rho = 2000, g = 10, H = 2;
  constexpr int n = 4;
  fem::Problem problem(MPI_COMM_WORLD, fem::BoxMesh{{1, H, 1}, {1, n, 1}, true, {}},
                       {1, 2, false, Kinematics::plane_strain, 1},
                       {plane("base", 1, 0, 1, 0), plane("left", 0, 0, 0, 0), plane("right", 0, 1, 0, 0)});
  problem.set_gravity({0, -g, 0}, std::vector<double>(problem.owned_points(), rho));
  double half = 0;  // nodes of a bar are where the closed form is; each bears its share of the weight
  for (int i = 1; i <= n; ++i) {
    const double y = H * i / n;
    half += 0.5 * (i < n ? 1 : 0.5) * rho * g * H / n * rho * g * (H * y - 0.5 * y * y) / M;
  }
  const auto all = increments(problem, fem::elastic_material(problem.owned_points(), E, nu), 2);
  for (const auto& e : all) {
    CHECK(e.external == Approx(half).epsilon(1e-7));
    CHECK(e.internal == Approx(half).epsilon(1e-7));
  }
}

TEST_CASE("one element of grains: loads do the work that the grains have taken, within what their rate costs") {
  const fem::test::Sand& sand = fem::test::standard();
  coupling::RveOptions with;
  with.response.quasi_static = sand.q;
  for (const int number : {2, 16}) {
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 1}, true, {}}, {1, 2, true},
                         {plane("top", 2, 1, 2, -0.01), plane("base", 2, 0, 2, 0), plane("x0", 0, 0, 0, 0),
                          plane("x1", 0, 1, 0, 0), plane("y0", 1, 0, 1, 0), plane("y1", 1, 1, 1, 0)});
    coupling::RveFarm farm(MPI_COMM_SELF, sand.model, with.response, 1);
    coupling::RveMaterial rves(farm, {sand.state}, std::vector<std::size_t>(problem.owned_points(), 0), with);
    fem::Material m = rves.material();
    fem::StaticsOptions o;
    o.increments = number, o.tolerance = 1e-2;
    MacroEnergy last;
    REQUIRE(fem::solve_statics(problem, m, o, [&](const fem::IncrementReport& r) {
              return last = r.energy, true;
            }).converged);
    CHECK(last.external == Approx(last.work).epsilon(1e-6));  // all is prescribed: the same trapezoids by other sums
    CHECK(last.internal == Approx(rves.total(&dem::Facts::work, std::vector<double>(8, 0.125))).epsilon(1e-9));
    CHECK(std::abs(last.error()) < 0.01);
  }
}

}  // namespace grus
