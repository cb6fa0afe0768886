// SPDX-License-Identifier: LGPL-3.0-or-later
// Finite elements against closed forms: patch test, convergence rates, plasticity, cutbacks, and an RVE in an element.
#include "coupling/rve_material.hpp"
#include "dem/rve/measure.hpp"
#include "fem/statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/helpers.hpp"

namespace grus {  // headers of DOLFINx bring another `fem` into the global space

using fem::Point;
using fem::test::plane;

namespace {

constexpr double pi = 3.14159265358979323846;

bool on_boundary(const Point& x) {
  for (double v : x)
    if (v < 1e-9 || v > 1 - 1e-9) return true;
  return false;
}

/// Moves nodes of the unit cube, those of a face along it only.
Point distorted(const Point& x) {
  auto bump = [](double a, double b, double c) { return 0.08 * std::sin(pi * a) * std::cos(2 * b + c); };
  return {x[0] + bump(x[0], x[1], x[2]), x[1] + bump(x[1], x[2], x[0]), x[2] + bump(x[2], x[0], x[1])};
}

fem::BoundaryCondition everywhere(std::function<Point(const Point&)> u) {
  fem::BoundaryCondition bc;
  bc.name = "all", bc.where = on_boundary, bc.displacement = {0.0, 0.0, 0.0}, bc.at = std::move(u);
  return bc;
}

/// Rollers on the three low faces, the top moved along z; confined: all sides are rollers.
std::vector<fem::BoundaryCondition> uniaxial(double top, bool confined) {
  std::vector<fem::BoundaryCondition> b{plane("x0", 0, 0, 0, 0), plane("y0", 1, 0, 1, 0), plane("z0", 2, 0, 2, 0),
                                        plane("top", 2, 1, 2, top)};
  if (confined) b.push_back(plane("x1", 0, 1, 0, 0)), b.push_back(plane("y1", 1, 1, 1, 0));
  return b;
}

bool always(const fem::IncrementReport&) { return true; }

fem::StaticsOptions options(int increments, double tolerance, double displacement) {
  fem::StaticsOptions o;
  o.increments = increments, o.tolerance = tolerance, o.displacement_tolerance = displacement;
  return o;
}

}  // namespace

TEST_CASE("patch test: uniform strain on a distorted mesh is exact, hexahedra and tetrahedra of order 1 and 2") {
  for (bool hexahedron : {true, false})
    for (int order : {1, 2}) {
      const double G[3][3] = {{1e-3, 2e-4, -3e-4}, {1e-4, -5e-4, 2e-4}, {3e-4, -1e-4, 7e-4}};
      fem::Problem problem(MPI_COMM_WORLD, {{1, 1, 1}, {3, 3, 3}, hexahedron, distorted},
                           {order, order == 1 ? 2 : 4, false}, {everywhere([&](const Point& x) {
                             Point u{};
                             for (std::size_t i = 0; i < 3; ++i)
                               for (std::size_t j = 0; j < 3; ++j) u[i] += G[i][j] * x[j];
                             return u;
                           })});
      fem::Material m = fem::elastic_material(problem.owned_points(), 10e9, 0.3);
      REQUIRE(fem::solve_statics(problem, m, options(1, 1e-10, 1e-10), always).converged);
      const double lambda = 10e9 * 0.3 / (1.3 * 0.4), mu = 10e9 / 2.6, trace = G[0][0] + G[1][1] + G[2][2];
      const double exact[6] = {lambda * trace + 2 * mu * G[0][0], lambda * trace + 2 * mu * G[1][1],
                               lambda * trace + 2 * mu * G[2][2], mu * (G[1][2] + G[2][1]),
                               mu * (G[0][2] + G[2][0]),          mu * (G[0][1] + G[1][0])};
      double worst = 0;
      for (std::size_t i = 0; i < problem.owned_points(); ++i)
        for (std::size_t k = 0; k < 6; ++k) worst = std::max(worst, std::abs(problem.stress()[6 * i + k] - exact[k]));
      CHECK(worst < 1e-10 * 10e6);  // of the stress, some 10 MPa
    }
}

TEST_CASE("manufactured solution: order 1 converges with 2 and 1, order 2 with 3 and 2") {
  const double E = 1e9, nu = 0.25, lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu)), a = 1e-4;
  auto u = [&](const Point& x) {
    return Point{a * std::sin(pi * x[0]) * std::sin(pi * x[1]) * std::sin(pi * x[2]), 0, 0};
  };
  auto gradient = [&](const Point& x) {
    const double sx = std::sin(pi * x[0]), sy = std::sin(pi * x[1]), sz = std::sin(pi * x[2]), cx = std::cos(pi * x[0]),
                 cy = std::cos(pi * x[1]), cz = std::cos(pi * x[2]);
    return std::array<double, 9>{a * pi * cx * sy * sz, a * pi * sx * cy * sz, a * pi * sx * sy * cz, 0, 0, 0, 0, 0, 0};
  };
  auto force = [&](const Point& x) {  // -div sigma = -[(lambda + mu) grad div u + mu laplace u]
    const double sx = std::sin(pi * x[0]), sy = std::sin(pi * x[1]), sz = std::sin(pi * x[2]), cx = std::cos(pi * x[0]),
                 cy = std::cos(pi * x[1]), cz = std::cos(pi * x[2]);
    const double p2 = a * pi * pi;
    return Point{(lambda + mu) * p2 * sx * sy * sz + 3 * mu * p2 * sx * sy * sz, -(lambda + mu) * p2 * cx * cy * sz,
                 -(lambda + mu) * p2 * cx * sy * cz};
  };
  for (bool hexahedron : {true, false})
    for (int order : {1, 2}) {
      std::array<double, 2> before{};
      for (long n : {4L, 8L}) {
        fem::Problem problem(MPI_COMM_WORLD, {{1, 1, 1}, {n, n, n}, hexahedron, {}}, {order, 2 * order + 1, false},
                             {everywhere(u)}, force);
        fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
        REQUIRE(fem::solve_statics(problem, m, options(1, 1e-9, 1e-8), always).converged);
        const auto error = problem.error_norms(u, gradient);
        if (n == 8) {
          CHECK(std::log2(before[0] / error[0]) == Approx(order + 1).margin(0.3));
          CHECK(std::log2(before[1] / error[1]) == Approx(order).margin(0.25));
        }
        before = error;
      }
    }
}

TEST_CASE("elastic oedometer and traction: closed forms and reactions") {
  fem::Problem problem(MPI_COMM_WORLD, {{1, 1, 1}, {2, 2, 2}, true, {}}, {1, 2, false}, uniaxial(-1e-3, true));
  fem::Material m = fem::elastic_material(problem.owned_points(), 10e6, 0.3);
  REQUIRE(fem::solve_statics(problem, m, options(1, 1e-10, 1e-10), always).converged);
  CHECK(problem.mean_stress()[2] == Approx(-13.461538e3).epsilon(1e-7));
  CHECK(problem.mean_stress()[0] / problem.mean_stress()[2] == Approx(3.0 / 7).epsilon(1e-6));
  CHECK(problem.reaction(3)[2] == Approx(-13.461538e3).epsilon(1e-7));
  auto pulled = uniaxial(0, false);
  pulled.back().displacement = {};
  pulled.back().traction = Point{0, 0, 5e3};
  for (bool hexahedron : {true, false}) {
    fem::Problem bar(MPI_COMM_WORLD, {{1, 1, 1}, {2, 3, 2}, hexahedron, {}}, {2, 4, false}, pulled);
    fem::Material e = fem::elastic_material(bar.owned_points(), 10e6, 0.3);
    REQUIRE(fem::solve_statics(bar, e, options(2, 1e-10, 1e-10), always).converged);
    CHECK(bar.mean_strain()[2] == Approx(5e-4).epsilon(1e-8));
    CHECK(bar.mean_strain()[0] == Approx(-1.5e-4).epsilon(1e-8));
  }
}

TEST_CASE("J2 bar in uniaxial stress follows the closed form, quadratically") {
  const double E = 200e9, yield = 250e6, H = 10e9, strain = 5e-3;
  fem::Problem problem(MPI_COMM_WORLD, {{1, 1, 1}, {2, 2, 2}, true, {}}, {1, 2, false}, uniaxial(strain, false));
  fem::Material m = fem::j2_material(problem.owned_points(), E, 0.3, yield, H);
  int most = 0;
  const auto result = fem::solve_statics(problem, m, options(5, 1e-10, 1e-8), [&](const fem::IncrementReport& r) {
    most = std::max(most, r.iterations);
    return true;
  });
  REQUIRE(result.converged);
  CHECK(problem.mean_stress()[2] == Approx(yield + E * H / (E + H) * (strain - yield / E)).epsilon(1e-8));
  CHECK(std::abs(problem.mean_stress()[0]) < 1e-6 * yield);
  CHECK(most <= 8);  // consistent tangent
}

TEST_CASE("a rigid rotation of a block reaches the material as a rotation") {
  fem::Problem problem(MPI_COMM_WORLD, {{1, 1, 1}, {1, 1, 1}, true, {}}, {1, 2, true}, {everywhere([](const Point& x) {
                         const double c = std::cos(40 * pi / 180), s = std::sin(40 * pi / 180);
                         return Point{c * x[0] - s * x[1] - x[0], s * x[0] + c * x[1] - x[1], 0};
                       })});
  std::vector<double> seen;
  fem::Material m = fem::elastic_material(problem.owned_points(), 1, 0);
  m.respond = [&](const fem::Points& p) {
    seen.assign(p.deformation.begin(), p.deformation.end());
    std::fill(p.stress.begin(), p.stress.end(), 0.0);
    for (std::size_t i = 0; i < p.tangent.size(); ++i) p.tangent[i] = i % 36 % 7 == 0 ? 1e6 : 0;
    return true;
  };
  REQUIRE(fem::solve_statics(problem, m, options(1, 1e-6, 1e-3), always).converged);
  for (std::size_t i = 0; i < seen.size(); i += 9) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> f(seen.data() + i);
    CHECK((f.transpose() * f - Eigen::Matrix3d::Identity()).norm() < 1e-12);
    CHECK(f(1, 0) == Approx(std::sin(40 * pi / 180)).epsilon(1e-12));
  }
}

TEST_CASE("a refused increment is cut, and nothing unconverged is ever committed") {
  fem::Problem problem(MPI_COMM_WORLD, {{1, 1, 1}, {2, 1, 1}, true, {}}, {1, 2, false}, uniaxial(-0.01, true));
  fem::Material elastic = fem::elastic_material(problem.owned_points(), 1e9, 0.2), m = elastic;
  int commits = 0;
  m.respond = [&](const fem::Points& p) {
    for (std::size_t i = 8; i < p.deformation.size(); i += 9)
      if (p.deformation[i] < 1 - 0.003) return false;  // as an RVE that cannot take so large a step
    return elastic.respond(p);
  };
  m.commit = [&] { ++commits, elastic.commit(); };
  int cutbacks = 0, increments = 0;
  const auto result = fem::solve_statics(problem, m, options(2, 1e-8, 1e-6), [&](const fem::IncrementReport& r) {
    cutbacks += r.cutbacks, ++increments;
    return true;
  });
  REQUIRE(result.converged);
  CHECK(cutbacks > 0);
  CHECK(increments > 2);
  CHECK(commits == increments + 1);  // and the start
  CHECK(problem.mean_strain()[2] == Approx(-0.01).epsilon(1e-9));
  m.respond = [](const fem::Points&) { return false; };
  commits = 0;
  CHECK_FALSE(fem::solve_statics(problem, m, options(2, 1e-8, 1e-6), always).converged);
  CHECK(commits == 0);
}

TEST_CASE("one element in uniform strain gives the standalone RVE's numbers") {
  using namespace grus::dem;
  Model model = dem::test::linear_model(1e6, 0.8, 2650, 1e3);
  set_damping(model, 0.5);
  State s;
  const double R = 5e-4, edge = std::sqrt(2.0) * 2 * R * (1 - 1e-4);
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 2; ++y)
      for (int z = 0; z < 2; ++z)
        for (const Vec3& f : {Vec3(0, 0, 0), Vec3(0.5, 0.5, 0), Vec3(0.5, 0, 0.5), Vec3(0, 0.5, 0.5)})
          dem::test::add(s, PolyEllipsoid::sphere(R), edge * (Vec3(x, y, z) + f), 2650);
  s.boundary.cell.vectors = 2 * edge * Mat3::Identity();
  Team team(1);
  prepare(model, s, team);
  const auto shared = std::make_shared<const Model>(model);
  QuasiStatic q;
  q.unbalanced_force = q.stress_change = 1e-6, q.pressure_floor = 1e4;
  fem::Problem problem(MPI_COMM_WORLD, {{1, 1, 1}, {1, 1, 1}, true, {}}, {1, 2, true}, uniaxial(-1e-4, true));
  coupling::RveOptions with;
  with.response.quasi_static = q;
  coupling::RveFarm farm(MPI_COMM_SELF, shared, with.response, 2);
  coupling::RveMaterial rves(farm, {s}, std::vector<std::size_t>(problem.owned_points(), 0), with);
  fem::Material m = rves.material();
  int iterations = 0;
  REQUIRE(fem::solve_statics(problem, m, options(2, 1e-6, 1e-3), [&](const fem::IncrementReport& r) {
            iterations = std::max(iterations, r.iterations);
            return true;
          }).converged);
  CHECK(rves.report().distinct == 1);  // a homogeneous block advances one RVE, however many points it has
  CHECK(rves.report().asked == problem.owned_points() * rves.report().advanced);
  CHECK(iterations == 1);  // all components are prescribed: the predictor is exact
  Rve alone(shared, q, s);
  alone.advance({});
  alone.commit();
  const Mat3 before = alone.advance({}).stress;
  Increment first, second;
  first.deformation(2, 2) = 1 - 0.5e-4;
  second.deformation(2, 2) = (1 - 1e-4) / (1 - 0.5e-4);
  alone.advance(first);
  alone.commit();
  const Mat3 stress = alone.advance(second).stress;
  CHECK(problem.mean_stress()[2] == Approx(stress(2, 2)).epsilon(1e-6));
  CHECK(problem.mean_stress()[0] == Approx(stress(0, 0)).epsilon(1e-6));
  // And the closed form of the lattice; geometry changes by the strain, 1e-4, and by the overlap, 1e-4.
  CHECK((stress(2, 2) - before(2, 2)) / -1e-4 == Approx(2.545584e9).epsilon(2e-3));
  CHECK((stress(0, 0) - before(0, 0)) / (stress(2, 2) - before(2, 2)) == Approx(0.055556).epsilon(2e-2));
}

namespace {

using Row3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Stress that a material of one point answers to an increment, and commits.
Eigen::Matrix3d answer(fem::Material& m, const Eigen::Matrix3d& f) {
  const Row3 deformation = f;
  double stress[6], tangent[36];
  REQUIRE(m.respond({{deformation.data(), 9}, stress, tangent}));
  m.commit();
  Eigen::Matrix3d s;
  const int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
  for (int k = 0; k < 6; ++k) s(row[k], column[k]) = s(column[k], row[k]) = stress[k];
  return s;
}

Eigen::Matrix3d rotation(double degrees) {
  return Eigen::AngleAxisd(degrees * pi / 180, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
}

}  // namespace

TEST_CASE("elastic and J2 stresses turn with the body, whatever the increments, and survive a checkpoint") {
  Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
  stretch(0, 0) += 4e-3, stretch(1, 1) -= 1e-3, stretch(0, 1) = stretch(1, 0) = 2e-3;
  for (const bool plastic : {false, true}) {
    auto make = [&] {
      return plastic ? fem::j2_material(1, 200e9, 0.3, 250e6, 10e9) : fem::elastic_material(1, 200e9, 0.3);
    };
    fem::Material still = make();
    const Eigen::Matrix3d stress = answer(still, stretch);
    REQUIRE(stress.norm() > 3e8);
    // Stretched, then turned by 90 degrees at once or in ten steps: the stress is turned.
    for (const int steps : {1, 10}) {
      fem::Material m = make();
      answer(m, stretch);
      Eigen::Matrix3d last;
      for (int k = 0; k < steps; ++k) last = answer(m, rotation(90.0 / steps));
      CHECK((last - rotation(90) * stress * rotation(90).transpose()).norm() < 1e-9 * stress.norm());
      // What comes next is what it would be for a body that has never turned.
      fem::Material same = make();
      answer(same, stretch);
      const Eigen::Matrix3d on = answer(same, stretch),
                            turned = answer(m, rotation(90) * stretch * rotation(90).transpose());
      CHECK((turned - rotation(90) * on * rotation(90).transpose()).norm() < 1e-9 * on.norm());
    }
    // Committed state to bytes and back into another: the same answers; half of the bytes are refused.
    fem::Material first = make(), second = make();
    answer(first, stretch);
    const std::string bytes = first.save();
    second.load(bytes);
    CHECK((answer(first, stretch) - answer(second, stretch)).norm() == 0);
    CHECK((answer(second, stretch) - stress).norm() > 1e-3 * stress.norm());
    CHECK_THROWS_AS(second.load(bytes.substr(0, bytes.size() / 2)), std::invalid_argument);
  }
  // Elastic: one stretch or many give the same stress, since only the whole deformation counts.
  fem::Material once = fem::elastic_material(1, 200e9, 0.3), often = fem::elastic_material(1, 200e9, 0.3);
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity(), part = shear, last;
  shear(0, 1) = 0.2, part(0, 1) = 0.02;
  for (int k = 0; k < 10; ++k) last = answer(often, part);
  CHECK((answer(once, shear) - last).norm() < 1e-12 * last.norm());
  // Of materials put together each part keeps its own.
  std::vector<fem::Material> parts{fem::elastic_material(1, 200e9, 0.3), fem::j2_material(1, 200e9, 0.3, 250e6, 10e9)};
  fem::Material both = fem::composite_material(parts, {0, 1}),
                back = fem::composite_material(
                    {fem::elastic_material(1, 200e9, 0.3), fem::j2_material(1, 200e9, 0.3, 250e6, 10e9)}, {0, 1});
  Eigen::Matrix<double, 18, 1> f;
  for (int k = 0; k < 18; ++k) f[k] = stretch(k % 9 / 3, k % 3);
  double a[12], b[12];
  auto respond = [&](fem::Material& m, double* stress) {
    REQUIRE(m.respond({{f.data(), 18}, {stress, 12}, {}}));
    m.commit();
  };
  respond(both, a);
  back.load(both.save());
  respond(both, a), respond(back, b);
  for (int k = 0; k < 12; ++k) CHECK(a[k] == b[k]);
}

}  // namespace grus
