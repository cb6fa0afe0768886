// SPDX-License-Identifier: LGPL-3.0-or-later
// Elements that do not lock: mean dilatation (fbar) and serendipity. Tangent against differences, patch, Cook's
// membrane, no spurious modes.
#include "fem/problem_impl.hpp"

#include "fem/statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/fem/hyperelastic.hpp"
#include "tests/helpers.hpp"

namespace grus {  // DOLFINx has a namespace fem, too
namespace {

using fem::ElementKind;
using fem::Kinematics;
using fem::Point;
using fem::test::hyperelastic;

struct Kind {
  ElementKind element;
  int order;
};
constexpr Kind kinds[] = {{ElementKind::standard, 1}, {ElementKind::fbar, 1}, {ElementKind::serendipity, 2}};

fem::Discretisation with(const Kind& kind, Kinematics kinematics) {
  return {kind.order, 2, true, kinematics, 1, kind.element};
}

/// Unit box whose inner nodes are moved about: no element is a brick. In two dimensions the third entries are not read.
fem::BoxMesh distorted(long n) {
  fem::BoxMesh mesh{{1, 1, 1}, {n, n, n}, true, {}};
  mesh.map = [](const Point& x) {
    const auto bump = [](double t) { return 16 * t * t * (1 - t) * (1 - t); };
    const double b = 0.06 * bump(x[0]) * bump(x[1]) * (x[2] == 0 ? 1 : bump(x[2]));
    return Point{x[0] + b, x[1] - 0.7 * b, x[2] + 0.5 * b * (x[2] == 0 ? 0 : 1)};
  };
  return mesh;
}

template <class F>
void displace(fem::Problem::Impl& p, F&& u) {
  auto values = p.u->mutable_array();
  for (std::size_t n = 0; n < p.node_at.size(); ++n) {
    const Eigen::Vector3d at = u(Eigen::Vector3d(p.node_at[n][0], p.node_at[n][1], p.node_at[n][2]));
    for (std::size_t k = 0; k < p.width(); ++k) values[p.width() * n + k] = at[static_cast<int>(k)];
  }
}

Eigen::VectorXd forces(fem::Problem::Impl& p, fem::Material& m) {
  REQUIRE(p.strain_sweep());
  REQUIRE(m.respond({p.deformation, p.stress, p.tangent}));
  p.assemble_internal();
  return Eigen::Map<const Eigen::VectorXd>(p.internal->array().data(),
                                           static_cast<Eigen::Index>(p.internal->array().size()));
}

/// Stiffness of the whole mesh, dense.
Eigen::MatrixXd stiffness(const fem::Problem::Impl& p) {
  const auto size = static_cast<Eigen::Index>(p.u->array().size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(size, size);
  fem::Problem::Impl::Matrix k;
  for (std::int32_t c = 0; c < p.cells; ++c) {
    p.cell_tangent(c, k);
    const auto dofs = p.cell_nodes(c);
    const auto at = [&](Eigen::Index i) {
      return p.components * dofs[static_cast<std::size_t>(i / p.components)] + i % p.components;
    };
    for (Eigen::Index i = 0; i < k.rows(); ++i)
      for (Eigen::Index j = 0; j < k.cols(); ++j) all(at(i), at(j)) += k(i, j);
  }
  return all;
}

fem::BoundaryCondition far_away() {  // a problem needs one, and these are left free
  fem::BoundaryCondition b = fem::test::plane("low", 0, 0, 0, 0);
  b.displacement = {};
  b.traction = Point{0, 0, 0};
  return b;
}

}  // namespace

TEST_CASE(
    "one element kind after another: the tangent is the difference of the forces, in large strain, to round-off") {
  for (const Kind& kind : kinds)
    for (const Kinematics kinematics : {Kinematics::solid, Kinematics::plane_strain, Kinematics::axisymmetric}) {
      fem::Problem problem(MPI_COMM_SELF, distorted(2), with(kind, kinematics), {far_away()});
      fem::Problem::Impl& p = problem.impl();
      fem::Material m = hyperelastic(problem.owned_points(), 3e8, 5e8);
      const auto size = static_cast<Eigen::Index>(p.u->array().size());
      displace(p, [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
        return {0.1 * x[0] + 0.08 * x[0] * x[1], -0.12 * x[1] * (1 + 0.4 * x[0]), 0.05 * x[2] * (1 - x[0])};
      });
      const Eigen::VectorXd start = Eigen::Map<const Eigen::VectorXd>(p.u->array().data(), size);
      forces(p, m);
      Eigen::VectorXd v(size);
      for (Eigen::Index i = 0; i < size; ++i) v[i] = std::sin(1.0 + 3.7 * static_cast<double>(i));
      const Eigen::VectorXd predicted = stiffness(p) * v;
      Eigen::VectorXd side[2];
      const double h = 1e-6;
      for (int s = 0; s < 2; ++s) {
        Eigen::Map<Eigen::VectorXd>(p.u->mutable_array().data(), size) = start + (s == 0 ? h : -h) * v;
        side[s] = forces(p, m);
      }
      const Eigen::VectorXd measured = (side[0] - side[1]) / (2 * h);
      CAPTURE(static_cast<int>(kind.element), static_cast<int>(kinematics));
      CHECK((predicted - measured).norm() < 1e-7 * measured.norm());  // h^2 and round-off / h
    }
}

TEST_CASE("one element kind after another: nodal forces are the derivative of the stored energy") {
  for (const Kind& kind : kinds)
    for (const Kinematics kinematics : {Kinematics::solid, Kinematics::plane_strain, Kinematics::axisymmetric}) {
      fem::Problem problem(MPI_COMM_SELF, distorted(2), with(kind, kinematics), {far_away()});
      fem::Problem::Impl& p = problem.impl();
      const auto size = static_cast<Eigen::Index>(p.u->array().size());
      std::vector<double> volumes;
      for (std::size_t i = 0; i < problem.owned_points(); ++i) volumes.push_back(problem.point_volume(i));
      Eigen::VectorXd v(size);
      for (Eigen::Index i = 0; i < size; ++i) v[i] = std::cos(2.0 + 1.3 * static_cast<double>(i));
      const double h = 1e-6;
      double energy[2], power = 0;
      for (const int s : {0, 1, 2}) {  // before, after, between
        const double way[] = {-h, h, 0};
        fem::Material m = hyperelastic(problem.owned_points(), 3e8, 5e8);
        displace(p, [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
          return {0.1 * x[0] + 0.08 * x[0] * x[1], -0.12 * x[1] * (1 + 0.4 * x[0]), 0.05 * x[2]};
        });
        Eigen::Map<Eigen::VectorXd>(p.u->mutable_array().data(), size) += way[s] * v;
        const Eigen::VectorXd f = forces(p, m);
        m.commit();
        if (s < 2)
          energy[s] = m.energy(volumes);
        else
          power = f.dot(v);
      }
      CAPTURE(static_cast<int>(kind.element), static_cast<int>(kinematics));
      CHECK((energy[1] - energy[0]) / (2 * h) == Approx(power).epsilon(1e-7));
    }
}

TEST_CASE("patch: one element kind after another, a linear field at the boundary is linear inside") {
  for (const Kind& kind : kinds)
    for (const Kinematics kinematics : {Kinematics::solid, Kinematics::plane_strain}) {
      fem::BoundaryCondition all;
      all.name = "all";
      const bool flat = kinematics == Kinematics::plane_strain;
      all.where = [=](const Point& x) {
        bool on = false;
        for (std::size_t k = 0; k < (flat ? 2 : 3); ++k) on = on || std::abs(x[k]) < 1e-9 || std::abs(x[k] - 1) < 1e-9;
        return on;
      };
      for (std::size_t k = 0; k < (flat ? 2 : 3); ++k) all.displacement[k] = 0;
      const auto u = [=](const Point& x) {
        return Point{0.1 * x[0] + 0.05 * x[1], -0.2 * x[1] + 0.03 * x[0], flat ? 0 : 0.07 * x[2] - 0.02 * x[0]};
      };
      all.at = u;
      fem::Problem problem(MPI_COMM_SELF, distorted(3), with(kind, kinematics), {all});
      fem::Material m = hyperelastic(problem.owned_points(), 3e8, 5e8);
      fem::StaticsOptions o;
      o.increments = 1, o.tolerance = 1e-12, o.displacement_tolerance = 1e-12;
      REQUIRE(fem::solve_statics(problem, m, o, [](const fem::IncrementReport&) { return true; }).converged);
      double worst = 0;
      for (std::size_t i = 0; i < problem.owned_points(); ++i) {
        const double* f = problem.deformation().data() + 9 * i;
        worst =
            std::max({worst, std::abs(f[0] - 1.1), std::abs(f[1] - 0.05), std::abs(f[3] - 0.03), std::abs(f[4] - 0.8)});
      }
      CAPTURE(static_cast<int>(kind.element), flat);
      CHECK(worst < 1e-10);
    }
}

TEST_CASE(
    "Cook's membrane, nearly incompressible, plane strain: linear quadrilaterals lock, mean dilatation and serendipity "
    "do not") {
  // E = 250, nu = 0.4999, F = 100 on the right edge: the corner moves by 7.771 in linear theory; here a thousandth of
  // the load.
  const auto corner = [](const Kind& kind, long n) {
    fem::BoxMesh mesh{{48, 60, 1}, {n, n, 1}, true, {}};
    mesh.map = [](const Point& x) {
      const double s = x[0] / 48, t = x[1] / 60;
      return Point{x[0], 44 * s + t * (44 - 28 * s), 0};
    };
    auto clamp = fem::test::plane("clamp", 0, 0, 0, 0);
    clamp.displacement[1] = 0;
    auto edge = fem::test::plane("edge", 0, 48, 0, 0);
    edge.displacement = {};
    edge.traction = Point{0, 0.1 / 16, 0};
    fem::Problem problem(MPI_COMM_SELF, mesh, with(kind, Kinematics::plane_strain), {clamp, edge});
    fem::Material m = fem::elastic_material(problem.owned_points(), 250, 0.4999);
    fem::StaticsOptions o;
    o.increments = 1, o.tolerance = 1e-6;
    REQUIRE(fem::solve_statics(problem, m, o, [](const fem::IncrementReport&) { return true; }).converged);
    const auto fields = problem.gather_fields();
    double moved = 0;
    for (std::size_t i = 0; i < fields.nodes.size(); ++i)
      if (fields.nodes[i][0] > 48 - 1e-9 && fields.nodes[i][1] > 60 - 1e-9) moved = fields.displacement[i][1];
    return 1000 * moved;
  };
  CHECK(corner(kinds[0], 16) < 3);
  CHECK(corner(kinds[1], 16) == Approx(7.771).epsilon(0.03));
  CHECK(corner(kinds[2], 16) == Approx(7.771).epsilon(0.02));
}

TEST_CASE("no spurious modes: a free block has those of a rigid body and no others") {
  for (const Kind& kind : kinds)
    for (const Kinematics kinematics : {Kinematics::solid, Kinematics::plane_strain}) {
      const int rigid = kinematics == Kinematics::solid ? 6 : 3;
      fem::Problem problem(MPI_COMM_SELF, distorted(2), with(kind, kinematics), {far_away()});
      fem::Problem::Impl& p = problem.impl();
      fem::Material m = fem::elastic_material(problem.owned_points(), 1, 0.3);
      forces(p, m);
      const Eigen::MatrixXd k = stiffness(p);
      const Eigen::VectorXd modes =
          Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (k + k.transpose()), Eigen::EigenvaluesOnly)
              .eigenvalues();
      int zero = 0, tied = 0;  // inner nodes of serendipity elements have no stiffness at all
      for (Eigen::Index i = 0; i < modes.size(); ++i) zero += std::abs(modes[i]) < 1e-9 * modes.maxCoeff() ? 1 : 0;
      for (Eigen::Index i = 0; i < k.rows(); ++i) tied += k.row(i).norm() == 0 ? 1 : 0;
      CAPTURE(static_cast<int>(kind.element), rigid);
      CHECK(zero - tied == rigid);
      CHECK((kind.element == ElementKind::serendipity) == (tied > 0));
    }
}

TEST_CASE("what elements cannot be is refused") {
  const fem::BoxMesh triangles{{1, 1, 1}, {2, 2, 1}, false, {}}, bricks{{1, 1, 1}, {1, 1, 1}, true, {}};
  const auto refused = [](const fem::BoxMesh& mesh, const fem::Discretisation& d) {
    CHECK_THROWS_AS(fem::Problem(MPI_COMM_SELF, mesh, d, {far_away()}), std::invalid_argument);
  };
  refused(triangles, with(kinds[1], Kinematics::plane_strain));
  refused(triangles, with(kinds[2], Kinematics::plane_strain));
  refused(bricks, {2, 2, true, Kinematics::solid, 1, ElementKind::fbar});
  refused(bricks, {1, 2, true, Kinematics::solid, 1, ElementKind::serendipity});
  refused(bricks, {1, 2, false, Kinematics::solid, 1, ElementKind::fbar});
}

}  // namespace grus
