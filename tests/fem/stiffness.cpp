// SPDX-License-Identifier: LGPL-3.0-or-later
// Tangents against differences and rigid motion; what statics and dynamics do between two states, by closed forms of
// one element.
#include "fem/dynamics.hpp"
#include "fem/problem_impl.hpp"
#include "fem/statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/helpers.hpp"

namespace grus {  // headers of DOLFINx bring another `fem` into the global space

using fem::Kinematics;
using fem::Point;
using fem::test::plane;

namespace {

using Row3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Row6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Vec6 = Eigen::Matrix<double, 6, 1>;

constexpr int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};

bool always(const fem::IncrementReport&) { return true; }

fem::StaticsOptions options(int increments, double tolerance, double displacement) {
  fem::StaticsOptions o;
  o.increments = increments, o.tolerance = tolerance, o.displacement_tolerance = displacement;
  return o;
}

/// Stress and tangent that a material of one point answers to an increment, not committed.
std::pair<Vec6, Row6> asked(fem::Material& m, const Eigen::Matrix3d& f) {
  const Row3 deformation = f;
  std::pair<Vec6, Row6> out;
  REQUIRE(m.respond({{deformation.data(), 9}, {out.first.data(), 6}, {out.second.data(), 36}}));
  return out;
}

Eigen::Matrix3d strained(int component, double amount) {
  Eigen::Matrix3d f = Eigen::Matrix3d::Identity();
  if (component < 3)
    f(component, component) += amount;
  else
    f(row[component], column[component]) += 0.5 * amount, f(column[component], row[component]) += 0.5 * amount;
  return f;
}

/// A block of eight cells, stretched and sheared, all in balance or not.
fem::Problem stretched(bool finite, double amount, Kinematics kinematics = Kinematics::solid) {
  return fem::Problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1.2, 0.8}, {2, 2, 2}, true, {}},
                      fem::Discretisation{1, 2, finite, kinematics, 1},
                      {plane("low", 0, 0, 0, 0), plane("high", 0, 1, 0, amount)});
}

/// Nodal displacements of an affine field, in the problem's numbering.
void displace(fem::Problem::Impl& p, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& u) {
  auto values = p.u->mutable_array();
  for (std::size_t n = 0; n < p.node_at.size(); ++n) {
    const Eigen::Vector3d at = u({p.node_at[n][0], p.node_at[n][1], p.node_at[n][2]});
    for (std::size_t k = 0; k < p.width(); ++k) values[p.width() * n + k] = at[static_cast<int>(k)];
  }
}

std::vector<double> internal_forces(fem::Problem::Impl& p, fem::Material& m) {
  REQUIRE(p.strain_sweep());
  REQUIRE(m.respond({p.deformation, p.stress, p.tangent}));
  p.assemble_internal();
  return {p.internal->array().begin(), p.internal->array().end()};
}

/// K v, from the cells' tangents.
std::vector<double> product(const fem::Problem::Impl& p, const std::vector<double>& v) {
  std::vector<double> out(v.size(), 0.0);
  fem::Problem::Impl::Matrix k;
  for (std::int32_t c = 0; c < p.cells; ++c) {
    p.cell_tangent(c, k);
    const auto dofs = p.cell_nodes(c);
    const auto at = [&](int i) {
      return p.width() * static_cast<std::size_t>(dofs[static_cast<std::size_t>(i / p.components)]) +
             static_cast<std::size_t>(i % p.components);
    };
    for (int i = 0; i < k.rows(); ++i)
      for (int j = 0; j < k.cols(); ++j) out[at(i)] += k(i, j) * v[at(j)];
  }
  return out;
}

double norm(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

std::vector<double> minus(std::vector<double> a, const std::vector<double>& b, double factor = 1) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = factor * (a[i] - b[i]);
  return a;
}

}  // namespace

TEST_CASE(
    "the tangent of a stressed block turns its forces when the block turns: the initial-stress stiffness, exactly") {
  for (const Kinematics kinematics : {Kinematics::solid, Kinematics::plane_strain}) {
    fem::Problem problem = stretched(true, 0, kinematics);
    fem::Problem::Impl& p = problem.impl();
    fem::Material m = fem::elastic_material(problem.owned_points(), 1e9, 0.3);
    displace(p, [](const Eigen::Vector3d& x) {
      return Eigen::Vector3d(0.05 * x[0] + 0.03 * x[1], -0.02 * x[1] + 0.01 * x[0] * x[0], 0.04 * x[2]);
    });
    const std::vector<double> force = internal_forces(p, m);
    const Eigen::Vector3d turn =
        kinematics == Kinematics::solid ? Eigen::Vector3d(0.3, -0.5, 0.8) : Eigen::Vector3d(0, 0, 1);
    std::vector<double> rotation(force.size()), expected(force.size());
    for (std::size_t n = 0; n < p.node_at.size(); ++n) {
      Eigen::Vector3d x = Eigen::Vector3d::Zero(), f = Eigen::Vector3d::Zero();
      for (std::size_t k = 0; k < p.width(); ++k)
        x[static_cast<int>(k)] = p.node_at[n][k] + p.u->array()[p.width() * n + k],
        f[static_cast<int>(k)] = force[p.width() * n + k];
      const Eigen::Vector3d moved = turn.cross(x), turned = turn.cross(f);
      for (std::size_t k = 0; k < p.width(); ++k)
        rotation[p.width() * n + k] = moved[static_cast<int>(k)],
                                 expected[p.width() * n + k] = turned[static_cast<int>(k)];
    }
    CHECK(norm(minus(product(p, rotation), expected)) < 1e-12 * norm(expected));
  }
}

TEST_CASE("the block's tangent is the difference of its forces: to round-off in small strain, to the strain in large") {
  for (const Kinematics kinematics : {Kinematics::solid, Kinematics::plane_strain, Kinematics::axisymmetric})
    for (const bool finite : {false, true}) {
      fem::Problem problem = stretched(finite, 0, kinematics);
      fem::Problem::Impl& p = problem.impl();
      fem::Material m = fem::elastic_material(problem.owned_points(), 1e9, 0.3);
      const double size = 0.01;
      displace(p, [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
        return size * Eigen::Vector3d(x[0] + 0.3 * x[1], -0.2 * x[1] + 0.1 * x[0] * x[0], 0.4 * x[2]);
      });
      internal_forces(p, m);
      const std::vector<double> start(p.u->array().begin(), p.u->array().end());
      std::vector<double> v(start.size());
      for (std::size_t i = 0; i < v.size(); ++i) v[i] = std::sin(1.0 + 3.7 * static_cast<double>(i));
      const std::vector<double> predicted = product(p, v);
      std::vector<double> side[2];
      const double h = 1e-6;
      for (int s = 0; s < 2; ++s) {
        auto u = p.u->mutable_array();
        for (std::size_t i = 0; i < v.size(); ++i) u[i] = start[i] + (s ? -h : h) * v[i];
        side[s] = internal_forces(p, m);
      }
      const std::vector<double> measured = minus(side[0], side[1], 1 / (2 * h));
      CHECK(norm(minus(predicted, measured)) < (finite ? 2 * size : 1e-7) * norm(measured));
    }
}

TEST_CASE("means of a body are over the volume that it has now") {
  fem::BoundaryCondition all;  // the upper of two cells is stretched by a half
  all.name = "all", all.where = [](const Point&) { return true; }, all.displacement = {0.0, 0.0, 0.0};
  all.at = [](const Point& x) { return Point{0, 0, 0.5 * std::max(0.0, x[2] - 1)}; };
  for (const bool finite : {true, false}) {
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 2}, {1, 1, 2}, true, {}}, {1, 2, finite}, {all});
    fem::Material m = fem::elastic_material(problem.owned_points(), 1e8, 0.0);
    REQUIRE(fem::solve_statics(problem, m, options(1, 1e-8, 1e-6), always).converged);
    const double share = finite ? 1.5 / 2.5 : 0.5;
    CHECK(problem.mean_strain()[2] == Approx(0.5 * share).epsilon(1e-12));
    CHECK(problem.mean_stress()[2] == Approx(0.5e8 * share).epsilon(1e-12));
  }
}

TEST_CASE(
    "J2 yields in pure shear at sigma_y / sqrt(3), hardens by a third of H there, and its tangent is the difference of "
    "its stress") {
  const double E = 200e9, nu = 0.3, mu = E / 2.6, yield = 250e6, H = 10e9, tau = yield / std::sqrt(3.0);
  for (const double part : {0.99, 1.01, 3.0}) {
    fem::Material m = fem::j2_material(1, E, nu, yield, H);
    const double gamma = part * tau / mu;
    const auto [stress, tangent] = asked(m, strained(5, gamma));
    const double expected = part < 1 ? mu * gamma : tau + mu * (H / 3) / (mu + H / 3) * (gamma - tau / mu);
    CHECK(stress[5] == Approx(expected).epsilon(1e-5));  // U - 1 of a shear of 4e-3 has 1e-6 beside it
    CHECK(std::abs(stress[0]) < 1e-2 * stress[5]);
  }
  fem::Material m = fem::j2_material(1, E, nu, yield, H);
  Eigen::Matrix3d f = strained(0, 3e-3);
  f(1, 2) = f(2, 1) = 1e-3, f(1, 1) -= 1e-3;
  const Row6 tangent = asked(m, f).second;
  const double h = 1e-7;
  for (int e = 0; e < 6; ++e) {
    const Vec6 measured = (asked(m, strained(e, h) * f).first - asked(m, strained(e, -h) * f).first) / (2 * h);
    // The tangent is taken in U - 1, not in F: they differ by the strain itself.
    CHECK((measured - tangent.col(e)).norm() < 8e-3 * tangent.norm());
  }
  const Row6 elastic = asked(m, Eigen::Matrix3d::Identity()).second;
  CHECK((elastic - tangent).norm() > 0.2 * elastic.norm());
  // Energy: held and spent is what the stress did on the way, in a hundred steps.
  fem::Material on = fem::j2_material(1, E, nu, yield, H);
  double work = 0;
  Vec6 before = Vec6::Zero();
  for (int k = 0; k < 400; ++k) {
    const double next = 5e-3 * (k + 1) / 400, now = 5e-3 * k / 400;
    const Vec6 stress = asked(on, strained(5, next) * strained(5, now).inverse()).first;
    on.commit();
    work += 0.5 * (before[5] + stress[5]) * 5e-3 / 400, before = stress;
  }
  const double volume = 2;
  CHECK(on.energy({&volume, 1}) == Approx(2 * work).epsilon(2e-3));
}

TEST_CASE("points that carry nothing are held by a floor of stiffness, and do not spoil those that carry") {
  std::vector<fem::BoundaryCondition> b{plane("x0", 0, 0, 0, 0), plane("y0", 1, 0, 1, 0), plane("z0", 2, 0, 2, 0),
                                        plane("top", 2, 0.5, 2, -1e-3)};
  for (auto& bc : b)
    if (bc.name == "top") bc.where = [](const Point& x) { return std::abs(x[2] - 1) < 1e-9 && x[0] < 0.5 + 1e-9; };
  fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {2, 1, 1}, true, {}}, {1, 2, false}, b);
  fem::Material elastic = fem::elastic_material(problem.owned_points(), 1e9, 0.0), m = elastic;
  bool loose = false;
  m.respond = [&](const fem::Points& p) {
    if (!elastic.respond(p)) return false;
    for (std::size_t i = 0; i < problem.owned_points(); ++i)
      if (loose && problem.point_position(i)[0] > 0.5) {  // the cell whose free nodes nothing else holds
        std::fill_n(p.stress.begin() + static_cast<std::ptrdiff_t>(6 * i), 6, 0.0);
        if (!p.tangent.empty()) std::fill_n(p.tangent.begin() + static_cast<std::ptrdiff_t>(36 * i), 36, 0.0);
      }
    return true;
  };
  REQUIRE(fem::solve_statics(problem, m, options(4, 1e-8, 1e-6), [&](const fem::IncrementReport& r) {
            return loose = r.increment >= 1, true;
          }).converged);
  double carried = 0;
  for (std::size_t i = 0; i < problem.owned_points(); ++i)
    if (problem.point_position(i)[0] < 0.5) carried += problem.stress()[6 * i + 2] / 8;
  CHECK(carried == Approx(-1e6).epsilon(1e-6));
}

TEST_CASE("bulk viscosity of one step: linear and quadratic, in closed form") {
  const double speed = 10, rho = 2000, E = 1e8, h = 0.5;
  auto top = plane("top", 2, h, 2, -speed * 1e-4), low = plane("low", 2, 0, 2, 0);
  top.history.points = {{0, 0}, {1e-4, 1}};
  fem::Problem problem(
      MPI_COMM_SELF, fem::BoxMesh{{h, h, h}, {1, 1, 1}, true, {}}, {1, 2, false},
      {top, low, plane("x0", 0, 0, 0, 0), plane("x1", 0, h, 0, 0), plane("y0", 1, 0, 1, 0), plane("y1", 1, h, 1, 0)});
  fem::Material m = fem::elastic_material(problem.owned_points(), E, 0);
  fem::DynamicsOptions o;
  o.duration = 1e-6, o.time_step = 1e-6, o.linear_viscosity = 0.06, o.quadratic_viscosity = 1.5,
  o.max_energy_error = 1e9;
  const auto result = fem::solve_dynamics(problem, m, std::vector<double>(problem.owned_points(), rho), o,
                                          [](const fem::DynamicsReport&) { return true; });
  REQUIRE(result.finished);
  const double rate = speed / h, pressure = rho * h * (0.06 * std::sqrt(E / rho) * rate + 1.5 * 1.5 * h * rate * rate);
  CHECK(result.last.dissipated == Approx(pressure * rate * 1e-6 * h * h * h).epsilon(1e-4));  // of the volume now
}

TEST_CASE("a free mass under a constant force goes F t^2 / 2 m, from the first half kick on") {
  fem::BoundaryCondition push;
  push.name = "top", push.where = [](const Point& x) { return std::abs(x[2] - 1) < 1e-9; },
  push.traction = Point{0, 0, 7};
  push.history.points = {{0, 1}};
  fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 1}, true, {}}, {1, 2, false},
                       {plane("low", 2, 0, 2, 0), push});
  fem::Material none = fem::elastic_material(problem.owned_points(), 1, 0), m = none;
  m.respond = [](const fem::Points& p) {
    std::fill(p.stress.begin(), p.stress.end(), 0.0);
    std::fill(p.tangent.begin(), p.tangent.end(), 0.0);
    return true;
  };
  fem::DynamicsOptions o;
  o.duration = 0.5, o.time_step = 0.01, o.max_energy_error = 1e-9;
  const auto result = fem::solve_dynamics(problem, m, std::vector<double>(problem.owned_points(), 2000.0), o,
                                          [](const fem::DynamicsReport&) { return true; });
  REQUIRE(result.finished);
  const double mass = 0.5 * 2000;  // of the upper four nodes
  CHECK(problem.mean_strain()[2] == Approx(0.5 * 7 / mass * 0.25).epsilon(1e-12));
}

TEST_CASE("bulk viscosity acts in compression alone, takes what it says, and shortens the step") {
  const double E = 200e9, rho = 7800, xi = 0.2;
  for (const double speed : {-1.0, 1.0}) {  // pulled, pushed
    auto low = plane("low", 1, 0, 1, speed * 2e-4);
    low.history.points = {{0, 0}, {2e-4, 1}};
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{0.05, 1, 1}, {1, 40, 1}, true, {}},
                         {1, 2, false, Kinematics::plane_strain, 1},
                         {low, plane("left", 0, 0, 0, 0), plane("right", 0, 0.05, 0, 0)});
    fem::Material m = fem::elastic_material(problem.owned_points(), E, 0.0);
    fem::DynamicsOptions o;
    const double c = std::sqrt(E / rho), duration = 0.5 / c;
    o.duration = duration, o.linear_viscosity = xi, o.quadratic_viscosity = 1.2, o.max_energy_error = 0.3;
    const std::vector<double> density(problem.owned_points(), rho);
    double first = 0;
    const auto result =
        fem::solve_dynamics(problem, m, density, o, [&](const fem::DynamicsReport& r) { return first = r.dt, true; });
    REQUIRE(result.finished);
    const double bound = fem::stable_step(problem, density);
    const double whole = result.last.energy.external;
    // Where nothing is compressed nothing is lost but what the front's ripples take; a pushed front loses a share that
    // the balance confirms.
    if (speed < 0)
      CHECK(result.last.energy.viscous < 0.02 * whole);
    else
      CHECK(result.last.energy.viscous > 0.02 * whole);
    CHECK(std::abs(result.last.energy.error()) < (speed < 0 ? 5e-3 : 0.2 * result.last.energy.viscous / whole));
    CHECK(first <= 0.8 * (std::sqrt(1 + xi * xi) - xi) * bound * (1 + 1e-9));
  }
}

}  // namespace grus
