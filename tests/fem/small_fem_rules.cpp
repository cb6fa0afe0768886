// SPDX-License-Identifier: LGPL-3.0-or-later
// Rules of problems, loads and materials one by one: pressure on a face that is sheared, histories, body forces, whose
// displacement holds, means of every component, thickness, shapes of elements; materials side by side; serendipity
// functions, sums in quanta, ranks that share cores.
#include "fem/problem_impl.hpp"

#include "fem/cell_shape.hpp"
#include "fem/macro_energy.hpp"
#include "fem/nodal_quanta.hpp"
#include "fem/serendipity.hpp"
#include "fem/statics.hpp"
#include "fem/support.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/fem/session.hpp"
#include "tests/helpers.hpp"

namespace grus {  // DOLFINx has a namespace fem, too
namespace {

using fem::CellKind;
using fem::Kinematics;
using fem::Point;
using fem::test::plane;

/// A unit block of so many bricks that is deformed to x + H x, loaded by `load` at its far side of x.
fem::Problem deformed(const Eigen::Matrix3d& h, bool finite, fem::BoundaryCondition load, long cells = 2) {
  fem::BoundaryCondition all;
  all.name = "all", all.where = [](const Point&) { return true; }, all.displacement = {0.0, 0.0, 0.0};
  all.at = [h](const Point& x) {
    const Eigen::Vector3d u = h * Eigen::Vector3d(x[0], x[1], x[2]);
    return Point{u[0], u[1], u[2]};
  };
  load.name = "load", load.where = [](const Point& x) { return x[0] > 1 - 1e-9; };
  load.history.points = {{0, 1}};
  return fem::Problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {cells, cells, cells}, true, {}}, {1, 2, finite},
                      {load, all});
}

void solve(fem::Problem& problem, fem::Material m) {
  fem::StaticsOptions o;
  o.increments = 1;
  REQUIRE(fem::solve_statics(problem, m, o, [](const fem::IncrementReport&) { return true; }).converged);
}

Eigen::Vector3d sum_of(const fem::Problem::Impl& p) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto f = p.external->array();
  for (std::size_t i = 0; i < static_cast<std::size_t>(p.owned_nodes()) * p.width(); ++i)
    sum[static_cast<int>(i % p.width())] += f[i];
  return sum;
}

}  // namespace

TEST_CASE("rigid motions that nothing stops are told by their axes, in each kind of space") {
  const auto pinned = [](const Point& at, std::array<std::optional<double>, 3> by) {
    fem::BoundaryCondition b;
    b.name = "pin" + std::to_string(at[0] + 3 * at[1] + 7 * at[2]);
    b.where = [=](const Point& x) { return std::hypot(x[0] - at[0], x[1] - at[1], x[2] - at[2]) < 1e-9; };
    b.displacement = by;
    return b;
  };
  const auto loose = [](Kinematics k, std::vector<fem::BoundaryCondition> all) {
    all.push_back({}), all.back().name = "load", all.back().pressure = 1, all.back().tags = {};
    all.back().where = [](const Point& x) { return x[1] > 1 - 1e-9; };
    const long cells = 3;
    fem::Problem p(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {cells, cells, cells}, true, {}}, {1, 2, true, k, 1}, all);
    return fem::loose_motions(p);
  };
  const auto solid = Kinematics::solid, plain = Kinematics::plane_strain, round = Kinematics::axisymmetric;
  const auto x0 = plane("x0", 0, 0, 0, 0), y0 = plane("y0", 1, 0, 1, 0), z0 = plane("z0", 2, 0, 2, 0);
  const std::optional<double> free, held = 0.0;
  const std::string along = "moving along ", about = "turning about ", line = about + "the line through what is held";
  CHECK(loose(plain, {}) == along + "x and " + along + "y and " + about + "z");
  CHECK(loose(plain, {x0}) == along + "y");
  CHECK(loose(plain, {x0, y0}).empty());
  CHECK(loose(plain, {pinned({0, 0, 0}, {held, held, free})}) == about + "z");
  CHECK(loose(plain, {pinned({0, 0, 0}, {held, held, free}), pinned({1, 0, 0}, {free, held, free})}).empty());
  CHECK(loose(plain, {pinned({0, 0, 0}, {held, held, free}), pinned({1, 0, 0}, {held, free, free})}) == about + "z");
  CHECK(loose(round, {x0}) == along + "y");  // the axis holds the radius, and nothing moves along it
  CHECK(loose(round, {y0}).empty());
  CHECK(loose(solid, {}).find(along + "z and " + about + "x and " + about + "y and " + about + "z") !=
        std::string::npos);
  CHECK(loose(solid, {x0, y0}) == along + "z");
  CHECK(loose(solid, {z0}) == along + "x and " + along + "y and " + about + "z");
  CHECK(loose(solid, {x0, y0, z0}).empty());
  const auto corner = pinned({0, 0, 0}, {held, held, held});
  CHECK(loose(solid, {corner}) == about + "x and " + about + "y and " + about + "z");
  CHECK(loose(solid, {corner, pinned({1, 0, 0}, {held, held, held})}) == about + "x");
  CHECK(loose(solid, {corner, pinned({1, 1, 1}, {held, held, held})}) == line);
  // However far from the origin, and however short its lever.
  fem::BoxMesh far{{1, 1, 1}, {20, 20, 1}, true, {}};
  far.map = [](const Point& x) { return Point{x[0] + 1e4, x[1] - 1e5, 0}; };
  auto pin = pinned({1e4, -1e5, 0}, {held, held, free}), near = pinned({1e4 + 0.05, -1e5, 0}, {free, held, free});
  pin.where = [](const Point& x) { return std::hypot(x[0] - 1e4, x[1] + 1e5) < 1e-6; };
  near.where = [](const Point& x) { return std::hypot(x[0] - 1e4 - 0.05, x[1] + 1e5) < 1e-6; };
  fem::Problem with(MPI_COMM_SELF, far, {1, 2, true, plain, 1}, {pin, near}),
      without(MPI_COMM_SELF, far, {1, 2, true, plain, 1}, {pin});
  CHECK(fem::loose_motions(with).empty());
  CHECK(fem::loose_motions(without) == about + "z");
}

TEST_CASE("a pressure acts on the cofactors of the deformation, a traction on the face as it was") {
  Eigen::Matrix3d h;
  h << 0.1, 0.3, -0.2, 0.05, -0.1, 0.15, 0.4, -0.25, 0.2;
  fem::BoundaryCondition load;
  load.pressure = 3, load.traction = Point{0.5, -1, 2};
  fem::Problem problem = deformed(h, true, load);
  solve(problem, fem::elastic_material(problem.owned_points(), 1e8, 0.2));
  problem.impl().assemble_external(1);
  const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + h;
  const Eigen::Vector3d area = f.col(1).cross(f.col(2));  // of the far face, which its two edges span
  CHECK((sum_of(problem.impl()) - (Eigen::Vector3d(0.5, -1, 2) - 3 * area)).norm() < 1e-12);
}

TEST_CASE("a history is constant before its first point and beyond its last, and the time itself where it has none") {
  const fem::LoadHistory h{{{1, 2}, {3, 6}, {4, 5}}};
  CHECK((h.at(0) == 2 && h.at(1) == 2 && h.at(2) == 4 && h.at(3.5) == 5.5 && h.at(9) == 5));
  CHECK(fem::LoadHistory{}.at(0.3) == 0.3);
}

TEST_CASE("a body force grows with time; of two conditions for a component the first holds") {
  fem::BoundaryCondition far = plane("far", 0, 1, 0, 0.25), also = plane("also", 0, 1, 0, 0.5),
                         base = plane("base", 0, 0, 0, 0);
  also.displacement[1] = 0.125;
  fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 2}, {2, 2, 2}, true, {}}, {1, 2, false}, {far, also, base},
                       [](const Point& x) {
                         return Point{0, 0, 3 * x[0]};
                       });
  for (const double time : {0.25, 1.0}) {
    problem.impl().assemble_external(time);
    CHECK((sum_of(problem.impl()) - Eigen::Vector3d(0, 0, 3 * time)).norm() < 1e-12);  // mean 1.5 over two m^3
  }
  std::size_t first = 0;
  for (const fem::Prescribed& c : problem.impl().prescribed) {
    CHECK_FALSE((c.boundary == 1 && c.dof % 3 == 0));
    first += c.boundary == 0;
  }
  CHECK(first == 9);
}

TEST_CASE("means and fields of an evenly strained body are its strain and stress, each component") {
  const double E = 1e8, nu = 0.3, lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  Eigen::Matrix3d h;
  h << 1, 4, -6, 2, -2, 3, 5, -1, 7;
  h *= 1e-4;
  fem::Problem problem = deformed(h, false, {});
  solve(problem, fem::elastic_material(problem.owned_points(), E, nu));
  const std::array<double, 6> strain = problem.mean_strain(), stress = problem.mean_stress();
  const auto fields = problem.gather_fields();
  constexpr int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
  for (std::size_t k = 0; k < 6; ++k) {
    const double e = h(row[k], column[k]) + (k < 3 ? 0 : h(column[k], row[k]));
    const double s = (k < 3 ? lambda * h.trace() + 2 * mu * e : mu * e);
    CHECK(strain[k] == Approx(e).epsilon(1e-9));
    CHECK(stress[k] == Approx(s).epsilon(1e-9));
    for (const auto& of : fields.stress) CHECK(of[k] == Approx(s).epsilon(1e-9));
  }
  const Point moved = problem.mean_displacement(0);  // of the far side: its middle
  const Eigen::Vector3d middle = h * Eigen::Vector3d(1, 0.5, 0.5);
  for (std::size_t k = 0; k < 3; ++k)
    CHECK(moved[k] == Approx(middle[static_cast<int>(k)]).epsilon(1e-9).margin(1e-15));
}

TEST_CASE("small strains are meant over the volume as it was: between ends that stay their mean is none") {
  fem::BoundaryCondition all;
  all.name = "all", all.where = [](const Point&) { return true; }, all.displacement = {0.0, 0.0, 0.0};
  all.at = [](const Point& x) { return Point{0.4 * x[0] * (1 - x[0]), 0, 0}; };
  fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {4, 1, 1}, true, {}}, {1, 2, false}, {all});
  solve(problem, fem::elastic_material(problem.owned_points(), 1e8, 0.2));
  CHECK(std::abs(problem.mean_strain()[0]) < 1e-12);
  CHECK(std::abs(problem.mean_stress()[0]) < 1e-12 * 1e8);
}

TEST_CASE("a report tells the norm of all forces, inside and applied, and the mean of a tangent's diagonal") {
  const double E = 1e8, nu = 0.3, lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  fem::BoundaryCondition load;
  load.traction = Point{2e6, -1e6, 3e6};
  Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
  h(0, 0) = 0.01, h(1, 2) = 0.02;
  fem::Problem problem = deformed(h, false, load);
  fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
  fem::StaticsOptions o;
  o.increments = 1;
  double force = 0, stiffest = 0;
  REQUIRE(fem::solve_statics(problem, m, o, [&](const fem::IncrementReport& r) {
            force = r.largest_force, stiffest = r.stiffest;
            return true;
          }).converged);
  double inside = 0, applied = 0;
  for (const double f : problem.impl().internal->array()) inside += f * f;
  for (const double f : problem.impl().external->array()) applied += f * f;
  REQUIRE(std::min(inside, applied) > 0.1 * std::max(inside, applied));
  CHECK(force == Approx(std::sqrt(inside + applied)).epsilon(1e-9));
  CHECK(stiffest == Approx((3 * (lambda + 2 * mu) + 3 * mu) / 6).epsilon(1e-9));
}

TEST_CASE("no element turns inside out, whatever its strains are") {
  for (const bool finite : {false, true}) {
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
    h(0, 0) = -1.5;
    fem::Problem problem = deformed(h, finite, {});
    fem::Material m = fem::elastic_material(problem.owned_points(), 1e8, 0.2);
    fem::StaticsOptions o;
    o.increments = 1;
    double reached = 0;
    const auto done = fem::solve_statics(problem, m, o, [&](const fem::IncrementReport& r) {
      reached = r.load_factor;
      return true;
    });
    CHECK_FALSE(done.converged);
    CHECK(reached < 1 / 1.5);
  }
}

TEST_CASE("a plate of plane strain bears by its thickness") {
  double force[2];
  for (const bool thick : {false, true}) {
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {2, 2, 1}, true, {}},
                         {1, 2, false, Kinematics::plane_strain, thick ? 0.25 : 1.0},
                         {plane("base", 1, 0, 1, 0), plane("top", 1, 1, 1, 1e-3), plane("left", 0, 0, 0, 0)});
    solve(problem, fem::elastic_material(problem.owned_points(), 1e8, 0.2));
    force[thick] = problem.reaction(1)[1];
  }
  CHECK(force[0] == Approx(1e-3 * 1e8 / (1 - 0.04)).epsilon(1e-9));
  CHECK(force[1] == Approx(0.25 * force[0]).epsilon(1e-12));
}

TEST_CASE("elements are as good mirrored and however small; flat ones and folded ones are not") {
  const std::vector<Point> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  for (const double size : {1.0, 1e-6})
    for (const double mirror : {1.0, -1.0}) {
      std::vector<Point> flat, brick;
      for (const double z : {0.0, 1.0})
        for (const Point& x : square) brick.push_back({mirror * size * x[0], size * x[1], size * z});
      flat.assign(brick.begin(), brick.begin() + 4);
      CHECK(fem::cell_fault(fem::CellKind::quadrilateral, flat).empty());
      CHECK(fem::cell_fault(fem::CellKind::hexahedron, brick).empty());
      std::swap(flat[2], flat[3]);
      CHECK(fem::cell_fault(fem::CellKind::quadrilateral, flat) == "is folded over itself");
      for (Point& x : brick) x[2] = 0;
      CHECK(fem::cell_fault(fem::CellKind::hexahedron, brick) == "is flat");
    }
}

TEST_CASE("materials side by side: each point answers by its own, all are committed, the worst of them is told") {
  const double soft = 1e8, stiff = 3e8;
  std::vector<fem::Material> parts{fem::elastic_material(2, soft, 0), fem::elastic_material(1, stiff, 0)};
  parts[0].inertial_number = [] { return 0.2; }, parts[1].inertial_number = [] { return 0.1; };
  parts[0].noise = [] { return 0.03; }, parts[1].noise = [] { return 0.01; };
  fem::Material m = fem::composite_material(parts, {0, 1, 0});
  CHECK((m.inertial_number() == 0.2 && m.noise() == 0.03));
  std::vector<double> f, stress(18), tangent(108);
  const double stretch[3] = {1.01, 1.02, 1.03}, volume[3] = {2, 5, 11};
  for (const double s : stretch) f.insert(f.end(), {s, 0, 0, 0, 1, 0, 0, 0, 1});
  double held = 0;
  for (int k = 1; k <= 2; ++k) {  // twice the same increment: from what was committed
    REQUIRE(m.respond({f, stress, tangent}));
    m.commit();
    held = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double young = i == 1 ? stiff : soft, strain = std::pow(stretch[i], k) - 1;
      CHECK(stress[6 * i] == Approx(young * strain).epsilon(1e-9));
      CHECK(tangent[36 * i] == Approx(young).epsilon(1e-12));
      held += 0.5 * young * strain * strain * volume[i];
    }
  }
  CHECK(m.energy(volume) == Approx(held).epsilon(1e-9));
}

TEST_CASE(
    "an energy balance is what is missing over the largest energy, however small that is, and whatever its sign") {
  for (const double j : {1.0, 1e-9}) {  // in joules and in nanojoules
    fem::MacroEnergy e;
    e.kinetic = 1 * j, e.internal = 2 * j, e.external = -8 * j, e.viscous = 0.5 * j, e.damped = 0.25 * j;
    e.scaled = 4 * j;
    CHECK(e.error() == Approx((-8 - 1 - 2 - 0.5 - 0.25 + 4) / 8));
    CHECK(e.kinetic_over_internal() == Approx(1 / 8.0));
    e.largest = 16 * j;  // once
    CHECK(e.error() == Approx((-8 - 1 - 2 - 0.5 - 0.25 + 4) / 16));
    e.internal = -32 * j;
    CHECK(e.kinetic_over_internal() == Approx(1 / 32.0));
    e.note_largest();
    CHECK(e.largest == Approx(32 * j));
  }
  CHECK(fem::MacroEnergy().error() == 0);
  CHECK(fem::MacroEnergy().kinetic_over_internal() == 0);
}

TEST_CASE("elements are flat by their corners' volume over their longest edge, whichever corner it is") {
  for (const double size : {1e-4, 1.0, 1e4})
    for (const double thin : {2e-10, 0.5e-10}) {
      const std::string fault = thin > 1e-10 ? "" : "is flat";
      std::vector<Point> three{{0, 0, 0}, {size, 0, 0}, {0, thin * size, 0}};
      std::vector<Point> four{{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, thin * size}};
      CHECK(fem::cell_fault(CellKind::triangle, three) == fault);
      CHECK(fem::cell_fault(CellKind::tetrahedron, four) == fault);
      std::swap(three[0], three[1]), std::swap(four[0], four[3]);
      CHECK(fem::cell_fault(CellKind::triangle, three) == fault);
    }
  // Each edge of a corner may be the longest: a needle's volume is its length.
  for (std::size_t k = 1; k < 4; ++k)
    for (const double long_one : {0.5e5, 2e5}) {  // l / l^3 against 1e-10
      std::vector<Point> needle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      needle[k][k - 1] = long_one;
      CHECK(fem::cell_fault(CellKind::tetrahedron, needle) == (long_one < 1e5 ? "" : "is flat"));
      if (k == 3) continue;
      needle.pop_back();
      needle[k][k - 1] = 1e5 * long_one;  // l / l^2
      CHECK(fem::cell_fault(CellKind::triangle, needle) == (long_one < 1e5 ? "" : "is flat"));
    }
  // A hexahedron with any one corner pushed through the opposite one is folded there.
  const std::vector<Point> cube{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  for (std::size_t n = 0; n < 8; ++n) {
    std::vector<Point> folded = cube;
    for (double& v : folded[n]) v = v > 0.5 ? -1 : 2;
    CHECK(fem::cell_fault(CellKind::hexahedron, folded) == "is folded over itself");
    std::vector<Point> pressed = cube;
    for (double& v : pressed[n]) v = 0.2 + 0.6 * v;
    CHECK(fem::cell_fault(CellKind::hexahedron, pressed).empty());
  }
}

TEST_CASE("nodes inside a serendipity element follow those on its edges: weights by hand, squares exactly") {
  for (const std::size_t dim : {std::size_t{2}, std::size_t{3}}) {
    std::vector<double> nodes;  // of the Lagrange element, in no order of kinds
    const std::size_t count = dim == 2 ? 9 : 27;
    for (std::size_t n = 0; n < count; ++n)
      for (std::size_t k = 0, of = n; k < dim; ++k, of /= 3) nodes.push_back(0.5 * static_cast<double>(of % 3));
    const fem::Ties ties = fem::serendipity_ties(nodes, dim);
    REQUIRE((ties.kept.size() == (dim == 2 ? 8 : 20) && ties.inside.size() == (dim == 2 ? 1 : 7)));
    const auto middles = [&](std::size_t n) {  // coordinates of a node that are 1/2
      return std::count(nodes.begin() + static_cast<std::ptrdiff_t>(dim * n),
                        nodes.begin() + static_cast<std::ptrdiff_t>(dim * (n + 1)), 0.5);
    };
    for (std::size_t i = 0; i < ties.inside.size(); ++i) {
      const std::size_t n = ties.inside[i];
      CHECK(middles(n) > 1);
      for (std::size_t a = 0; a < ties.kept.size(); ++a) {
        const std::size_t m = ties.kept[a];
        CHECK(middles(m) <= 1);
        bool of_its_face = true;
        for (std::size_t k = 0; k < dim; ++k)
          of_its_face = of_its_face && (nodes[dim * n + k] == 0.5 || nodes[dim * n + k] == nodes[dim * m + k]);
        // In the middle of a face corners weigh -1/4 and edges 1/2; in that of a body -1/4 and 1/4.
        const double edge = middles(n) == 2 ? 0.5 : 0.25;
        CHECK(ties.weights[i][a] == Approx(of_its_face ? middles(m) == 0 ? -0.25 : edge : 0).margin(1e-14));
      }
    }
    // Values of the kept functions take on what the tied ones had: the sum stays.
    std::vector<double> values;
    for (std::size_t k = 0; k < 2 * count; ++k) values.push_back(static_cast<double>(k * k % 7) + 1);
    const std::vector<double> before = values;
    fem::tie(ties, count, values);
    for (const std::size_t row : {std::size_t{0}, count}) {
      double sum = 0, was = 0;
      for (std::size_t n = 0; n < count; ++n) sum += values[row + n], was += before[row + n];
      CHECK(sum == Approx(was).epsilon(1e-13));
      for (const std::size_t n : ties.inside) CHECK(values[row + n] == 0);
      double first = before[row + ties.kept[1]];
      for (std::size_t i = 0; i < ties.inside.size(); ++i) first += ties.weights[i][1] * before[row + ties.inside[i]];
      CHECK(values[row + ties.kept[1]] == Approx(first).epsilon(1e-13));
    }
  }
}

TEST_CASE("the largest contribution is without its sign, and infinite where one is no number") {
  using fem::Contribution;
  const auto largest = [](std::vector<Contribution> parts) { return fem::NodalQuanta::largest(parts); };
  CHECK((largest({}) == 0 && largest({{0, -3}, {1, 2}}) == 3 && largest({{0, 0}}) == 0));
  CHECK((std::isinf(largest({{0, 1}, {1, NAN}, {2, 2}})) && std::isinf(largest({{0, -INFINITY}, {0, 1}}))));
  const auto of_numbers = [](const std::vector<double>& v) { return fem::NodalQuanta::largest(v); };
  CHECK((of_numbers({}) == 0 && of_numbers({-3, 2}) == 3 && std::isinf(of_numbers({1, NAN, 2}))));
}

TEST_CASE("ranks share cores with those whose cores are among theirs, and with themselves") {
  const auto set = [](std::initializer_list<std::size_t> cores) {
    cpu_set_t of;
    CPU_ZERO(&of);
    for (const std::size_t k : cores) CPU_SET(k, &of);
    return of;
  };
  const std::vector<cpu_set_t> all{set({0, 1}), set({1, 2}), set({3}), set({0, 1, 2, 3}), set({5})};
  const int sharers[] = {3, 3, 2, 4, 1};
  for (std::size_t k = 0; k < all.size(); ++k) CHECK(fem::sharers_of(all, all[k]) == sharers[k]);
  int rank = 0, ranks = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const fem::Session* session = fem::test::session;
  REQUIRE(session != nullptr);
  CHECK((session->rank() == rank && session->ranks() == ranks));
  CHECK(session->sharers() == ranks);  // the tests bind none to a core
}

}  // namespace grus
