// SPDX-License-Identifier: LGPL-3.0-or-later
// Two dimensions, mesh files, pressure that follows its surface, load histories: against closed forms.
#include <filesystem>
#include <fstream>

#include "fem/statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/helpers.hpp"

namespace grus {  // headers of DOLFINx bring another `fem` into the global space

using fem::Kinematics;
using fem::Point;
using fem::test::plane;

namespace {

bool always(const fem::IncrementReport&) { return true; }

fem::StaticsOptions exact(int increments = 1) {
  fem::StaticsOptions o;
  o.increments = increments, o.tolerance = 1e-10, o.displacement_tolerance = 1e-10;
  return o;
}

fem::BoundaryCondition at(std::string name, std::function<bool(const Point&)> where) {
  fem::BoundaryCondition b;
  b.name = std::move(name), b.where = std::move(where);
  return b;
}

/// Interior nodes of the unit square moved, the edges left where they are.
Point wobbly(const Point& x) {
  const double bump = 0.06 * std::sin(3.14159265358979 * x[0]) * std::sin(3.14159265358979 * x[1]);
  return {x[0] + bump, x[1] - 0.7 * bump, 0};
}

std::string written(const std::string& name, const std::string& text) {
  int rank;  // ranks share the folder
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const std::string path =
      (std::filesystem::temp_directory_path() / ("grus_" + std::to_string(rank) + "_" + name)).string();
  std::ofstream(path) << text;
  return path;
}

/// Largest difference of a stress component from a value, relative to `scale`.
double worst(const fem::Problem& p, std::size_t component, double exact_value, double scale) {
  double most = 0;
  for (std::size_t i = 0; i < p.owned_points(); ++i)
    most = std::max(most, std::abs(p.stress()[6 * i + component] - exact_value) / scale);
  return most;
}

}  // namespace

TEST_CASE("patch test in plane strain and axisymmetry: uniform strain is exact on distorted cells") {
  const double E = 10e9, nu = 0.3, lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / 2.6;
  for (const auto kinematics : {Kinematics::plane_strain, Kinematics::axisymmetric})
    for (bool quadrilateral : {true, false})
      for (int order : {1, 2}) {
        const bool turned = kinematics == Kinematics::axisymmetric;
        const double xx = 1e-3, yy = -4e-4, xy = turned ? 0 : 3e-4;  // shear of a solid of revolution is not uniform
        auto all =
            at("all", [](const Point& x) { return x[0] < 1e-9 || x[0] > 1 - 1e-9 || x[1] < 1e-9 || x[1] > 1 - 1e-9; });
        all.displacement = {0.0, 0.0, std::nullopt};
        all.at = [=](const Point& x) { return Point{xx * x[0] + xy * x[1], yy * x[1] + xy * x[0], 0}; };
        fem::Problem problem(MPI_COMM_WORLD, {{1, 1, 1}, {4, 3, 1}, quadrilateral, wobbly},
                             {order, 5, false, kinematics, 1}, {all});
        fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
        REQUIRE(fem::solve_statics(problem, m, exact(), always).converged);
        const double zz = turned ? xx : 0, trace = xx + yy + zz;
        CHECK(worst(problem, 0, lambda * trace + 2 * mu * xx, 10e6) < 1e-9);
        CHECK(worst(problem, 1, lambda * trace + 2 * mu * yy, 10e6) < 1e-9);
        CHECK(worst(problem, 2, lambda * trace + 2 * mu * zz, 10e6) < 1e-9);
        CHECK(worst(problem, 5, 2 * mu * xy, 10e6) < 1e-9);
        CHECK(problem.current_volume() == Approx(turned ? M_PI : 1).epsilon(5e-3));
      }
}

TEST_CASE(
    "thick cylinder under pressure: Lame's solution, second order in the mesh; axisymmetric and plane strain agree") {
  const double E = 1e9, nu = 0.25, p = 1e5, a = 1, b = 2;
  const double A = p * a * a / (b * b - a * a), B = p * a * a * b * b / (b * b - a * a), mu = E / (2 * (1 + nu)),
               lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  auto radial = [&](double r) { return A * r / (2 * (lambda + mu)) + B / (2 * mu * r); };  // u_r in plane strain
  std::array<double, 2> error{};
  int level = 0;
  for (long n : {8L, 16L}) {
    auto inner = at("inner", [&](const Point& x) { return std::abs(x[0] - a) < 1e-9; });
    inner.pressure = p;
    fem::BoxMesh mesh{{1, 0.2, 1}, {n, 1, 1}, true, [&](const Point& x) { return Point{x[0] + a, x[1], 0}; }};
    fem::Problem ring(MPI_COMM_WORLD, mesh, {1, 3, false, Kinematics::axisymmetric, 1},
                      {plane("low", 1, 0, 1, 0), plane("high", 1, 0.2, 1, 0), inner});
    fem::Material m = fem::elastic_material(ring.owned_points(), E, nu);
    REQUIRE(fem::solve_statics(ring, m, exact(), always).converged);
    const auto moved = [&](const Point& x) { return Point{radial(x[0]), 0, 0}; };
    const auto stretch = [&](const Point& x) {
      return std::array<double, 9>{A / (2 * (lambda + mu)) - B / (2 * mu * x[0] * x[0])};
    };
    error[static_cast<std::size_t>(level++)] = ring.error_norms(moved, stretch)[0];
  }
  CHECK(std::log2(error[0] / error[1]) == Approx(2).margin(0.1));
  // A quarter of the same ring, cut across its axis.
  auto inner = at("inner", [&](const Point& x) { return std::abs(std::hypot(x[0], x[1]) - a) < 1e-6; });
  inner.pressure = p;
  fem::BoxMesh quarter{{1, 1, 1}, {12, 24, 1}, true, [&](const Point& x) {
                         const double r = a + (b - a) * x[0], angle = x[1] * M_PI / 2;
                         return Point{r * std::cos(angle), r * std::sin(angle), 0};
                       }};
  fem::Problem ring(MPI_COMM_WORLD, quarter, {2, 5, false, Kinematics::plane_strain, 1},
                    {plane("x0", 0, 0, 0, 0), plane("y0", 1, 0, 1, 0), inner});
  fem::Material m = fem::elastic_material(ring.owned_points(), E, nu);
  REQUIRE(fem::solve_statics(ring, m, exact(), always).converged);
  const auto off = ring.error_norms(
      [&](const Point& x) {
        const double r = std::hypot(x[0], x[1]);
        return Point{radial(r) * x[0] / r, radial(r) * x[1] / r, 0};
      },
      [](const Point&) { return std::array<double, 9>{}; })[0];
  CHECK(off <
        2e-3 * radial(a) * std::sqrt(M_PI / 4 * 3));  // straight cell edges cut the circle by (pi / 96)^2 / 2 of r
}

TEST_CASE("pressure follows its surface, a traction does not") {
  // Uniaxially free block under pressure p on all outer faces: whatever its shape, the stress is -p.
  const double E = 1e6, p = 2e5;
  auto top = at("top", [](const Point& x) { return std::abs(x[1] - 1) < 1e-9; });
  auto side = at("side", [](const Point& x) { return std::abs(x[0] - 1) < 1e-9; });
  top.pressure = p, side.pressure = p;
  fem::Problem problem(MPI_COMM_WORLD, {{1, 1, 1}, {2, 2, 1}, true, {}}, {1, 2, true, Kinematics::axisymmetric, 1},
                       {plane("low", 1, 0, 1, 0), plane("axis", 0, 0, 0, 0), top, side});
  fem::Material m = fem::elastic_material(problem.owned_points(), E, 0.2);
  REQUIRE(fem::solve_statics(problem, m, exact(8), always).converged);
  for (std::size_t k : {0UL, 1UL, 2UL}) CHECK(worst(problem, k, -p, p) < 1e-8);
  // The side has shrunk by 11 % or so: dead loads would leave p / (lambda_2 lambda_3).
  CHECK(problem.mean_strain()[0] < -0.1);
}

TEST_CASE("load histories: a pressure that is held while a displacement comes and goes") {
  const double E = 1e9, nu = 0.2, p = 1e6;
  auto side = at("side", [](const Point& x) { return std::abs(x[0] - 1) < 1e-9; });
  side.pressure = p, side.history.points = {{0, 1}};
  auto top = plane("top", 1, 1, 1, -1e-3);
  top.history.points = {{0, 0}, {0.5, 1}, {1, 0.25}};
  fem::Problem problem(MPI_COMM_WORLD, {{1, 1, 1}, {2, 2, 1}, true, {}}, {1, 2, false, Kinematics::axisymmetric, 1},
                       {plane("low", 1, 0, 1, 0), plane("axis", 0, 0, 0, 0), top, side});
  fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
  int seen = 0;
  REQUIRE(fem::solve_statics(problem, m, exact(4), [&](const fem::IncrementReport& r) {
            const double strain = -1e-3 * (r.load_factor <= 0.5 ? 2 * r.load_factor : 1 - 1.5 * (r.load_factor - 0.5));
            CHECK(problem.mean_stress()[0] == Approx(-p).epsilon(1e-8));
            CHECK(problem.mean_stress()[1] ==
                  Approx(E * strain - 2 * nu * p).epsilon(1e-8));  // sigma_y = E eps_y + 2 nu sigma_r
            ++seen;
            return true;
          }).converged);
  CHECK(seen == 4);
}

TEST_CASE("a softening bar passes its peak under displacement control, by the closed form") {
  const double E = 200e9, yield = 250e6, H = -5e9;
  fem::Problem problem(
      MPI_COMM_WORLD, {{1, 1, 1}, {1, 1, 1}, true, {}}, {1, 2, false},
      {plane("x0", 0, 0, 0, 0), plane("y0", 1, 0, 1, 0), plane("z0", 2, 0, 2, 0), plane("top", 2, 1, 2, 5e-3)});
  fem::Material m = fem::j2_material(problem.owned_points(), E, 0.3, yield, H);
  double peak = 0;
  REQUIRE(fem::solve_statics(problem, m, exact(20), [&](const fem::IncrementReport&) {
            peak = std::max(peak, problem.mean_stress()[2]);
            return true;
          }).converged);
  CHECK(peak == Approx(yield).epsilon(1e-8));  // an increment ends at the yield strain, 1.25e-3
  CHECK(problem.mean_stress()[2] == Approx(yield + E * H / (E + H) * (5e-3 - yield / E)).epsilon(1e-7));
}

TEST_CASE("mesh files: both formats, tags, and one line for what is wrong") {
  const std::string v2 =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 1 \"low\"\n1 2 \"high\"\n2 7 "
      "\"sand\"\n$EndPhysicalNames\n"
      "$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 2 0 0\n4 0 1 0\n5 1 1 0\n6 2 1 0\n$EndNodes\n"
      "$Elements\n5\n1 1 2 1 1 1 2\n2 1 2 1 1 2 3\n3 1 2 2 2 4 5\n4 3 2 7 1 1 2 5 4\n5 3 2 9 1 2 3 6 5\n$EndElements\n";
  const fem::MshMesh mesh = fem::read_msh(written("two.msh", v2));
  CHECK(mesh.kind == fem::CellKind::quadrilateral);
  CHECK(mesh.cell_tags == std::vector<int>{7, 9});
  CHECK(mesh.facets.size() == 3);
  CHECK(mesh.facet_names.at("high") == std::vector<int>{2});
  fem::BoundaryCondition low, high;
  low.name = "low", low.tags = {1}, low.displacement = {0.0, 0.0, std::nullopt};
  high.name = "high", high.tags = {2}, high.displacement = {std::nullopt, 1e-3, std::nullopt};
  fem::Problem problem(MPI_COMM_WORLD, mesh, {1, 2, false, Kinematics::plane_strain, 1}, {low, high});
  fem::Material m = fem::elastic_material(problem.owned_points(), 1e9, 0.2);
  REQUIRE(fem::solve_statics(problem, m, exact(), always).converged);
  CHECK(problem.reaction(0)[1] == Approx(-problem.reaction(1)[1]).epsilon(1e-9));
  CHECK(problem.reaction(1)[1] > 0);
  int tags = 0;
  for (std::size_t i = 0; i < problem.owned_points(); ++i) tags += problem.cell_tag(i);
  int all = 0;
  MPI_Allreduce(&tags, &all, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  CHECK(all == 4 * (7 + 9));
  auto message = [&](const std::string& text) {
    try {
      fem::read_msh(written("bad.msh", text));
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = v2;
    text.replace(text.find(from), from.size(), to);
    return message(text);
  };
  CHECK(changed("2.2 0 8", "2.2 1 8").find("binary") != std::string::npos);
  CHECK(changed("2.2 0 8", "3.0 0 8").find("not read") != std::string::npos);
  CHECK(changed("5 3 2 9 1 2 3 6 5", "5 2 2 9 1 2 3 6").find("mixes") != std::string::npos);
  CHECK(changed("5 3 2 9 1 2 3 6 5", "5 3 2 9 1 2 3 8 5").find("node 8") != std::string::npos);
  CHECK(changed("5 3 2 9 1 2 3 6 5", "5 10 2 9 1 2 3 6 5").find("element type 10") != std::string::npos);
  CHECK(message(v2.substr(0, v2.size() - 40)).find("$Elements: cut short") != std::string::npos);
  CHECK(changed("6 2 1 0\n", "6 2 1 0.5\n").find("plane z = 0") != std::string::npos);
  CHECK(changed("4 3 2 7 1 1 2 5 4\n5 3 2 9 1 2 3 6 5", "4 1 2 7 1 1 2\n5 1 2 9 1 2 3").find("holds no triangles") !=
        std::string::npos);
  const std::string fan =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 0 -1 0\n"
      "$EndNodes\n$Elements\n3\n1 2 2 1 1 1 2 3\n2 2 2 1 1 1 2 4\n3 2 2 1 1 1 5 2\n$EndElements\n";
  CHECK(message(fan).find("share the side with nodes 1 2: they overlap") != std::string::npos);
  CHECK(changed("1 1 2 1 1 1 2", "1 1 2 -1 1 1 2") == "accepted");
  CHECK(fem::read_msh(written("bad.msh", v2)).notes.empty());
  std::string negative = v2;
  negative.replace(negative.find("1 1 2 1 1 1 2"), 13, "1 1 2 -1 1 1 2");
  CHECK(fem::read_msh(written("negative.msh", negative)).facets == mesh.facets);
}

}  // namespace grus
