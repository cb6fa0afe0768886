// SPDX-License-Identifier: LGPL-3.0-or-later
// RVEs at Gauss points: one element against the standalone RVE, objectivity, Hill-Mandel, what sharing and deferral
// leave out, and an RVE that refuses an increment.
#include <cstdio>

#include "coupling/rve_material.hpp"
#include "coupling/start_stiffness.hpp"
#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/linear_response.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "fem/dynamics.hpp"
#include "fem/statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/fem/sand.hpp"

namespace grus {  // headers of DOLFINx bring another `fem` into the global space

using namespace grus::dem;
using fem::Point;
using fem::test::plane;
using fem::test::Sand, fem::test::sand, fem::test::standard;

namespace {

bool always(const fem::IncrementReport&) { return true; }

fem::StaticsOptions options(int increments, double tolerance = 1e-6) {
  fem::StaticsOptions o;
  o.increments = increments, o.tolerance = tolerance;
  return o;
}

fem::BoundaryCondition everywhere(const Mat3& gradient) {
  fem::BoundaryCondition bc;
  bc.name = "all", bc.displacement = {0.0, 0.0, 0.0};
  bc.where = [](const Point& x) {
    return *std::min_element(x.begin(), x.end()) < 1e-9 || *std::max_element(x.begin(), x.end()) > 1 - 1e-9;
  };
  bc.at = [gradient](const Point& x) {
    const Vec3 u = gradient * Vec3(x[0], x[1], x[2]);
    return Point{u[0], u[1], u[2]};
  };
  return bc;
}

/// One element of the given sand and what drives it; every rank has its own.
struct Element {
  fem::Problem problem;
  coupling::RveOptions with;
  coupling::RveFarm farm;
  coupling::RveMaterial rves;
  fem::Material material;

  Element(const Sand& s, std::vector<fem::BoundaryCondition> b, coupling::RveOptions o = {},
          std::array<long, 3> cells = {1, 1, 1})
      : problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, cells, true, {}}, {1, 2, true}, std::move(b)),
        with((o.response.quasi_static = s.q, o)),
        farm(MPI_COMM_SELF, s.model, with.response, 2),
        rves(farm, {s.state}, std::vector<std::size_t>(problem.owned_points(), 0), with),
        material(rves.material()) {}

  Mat3 F() const {
    Mat3 f;
    for (int k = 0; k < 9; ++k) f(k / 3, k % 3) = problem.deformation()[static_cast<std::size_t>(k)];
    return f;
  }
  Vec6 stress(std::size_t point = 0) const {
    Vec6 s;
    for (int k = 0; k < 6; ++k) s[k] = problem.stress()[6 * point + static_cast<std::size_t>(k)];
    return s;
  }
};

/// As RveMaterial takes increments.
Mat3 snapped(const Mat3& m) {
  return m.unaryExpr([](double v) { return std::ldexp(std::nearbyint(std::ldexp(v, 34)), -34); });
}

/// Runs both on the same increments; largest difference of stresses on the way, relative.
double worst_difference(Element& plain, Element& other, int increments) {
  std::vector<Vec6> truth;
  REQUIRE(fem::solve_statics(plain.problem, plain.material, options(increments), [&](const fem::IncrementReport&) {
            truth.push_back(plain.stress());
            return true;
          }).converged);
  std::size_t at = 0;
  double worst = 0;
  REQUIRE(fem::solve_statics(other.problem, other.material, options(increments), [&](const fem::IncrementReport&) {
            worst = std::max(worst, (other.stress() - truth[at]).norm() / truth[at].norm());
            ++at;
            return true;
          }).converged);
  return worst;
}

Mat3 shear(double amount) {
  Mat3 g = Mat3::Zero();
  g(0, 2) = amount;
  return g;
}

}  // namespace

TEST_CASE("an element in drained triaxial compression and in simple shear is the standalone RVE on the same path") {
  for (bool triaxial : {true, false}) {
    std::vector<fem::BoundaryCondition> b{everywhere(shear(0.02))};
    if (triaxial) {
      b = {plane("x0", 0, 0, 0, 0), plane("y0", 1, 0, 1, 0), plane("z0", 2, 0, 2, 0), plane("top", 2, 1, 2, -0.01)};
      for (std::size_t axis : {0UL, 1UL}) {
        fem::BoundaryCondition side;
        side.name = axis == 0 ? "x1" : "y1";
        side.where = [axis](const Point& x) { return std::abs(x[axis] - 1) < 1e-9; };
        side.pressure = 1e5, side.history.points = {{0, 1}};
        b.push_back(side);
      }
    }
    Element element(standard(), b);
    Rve alone(standard().model, standard().q, standard().state);
    alone.advance({});
    alone.commit();
    Mat3 before = Mat3::Identity();
    double worst = 0;
    REQUIRE(fem::solve_statics(element.problem, element.material, options(8), [&](const fem::IncrementReport&) {
              const Mat3 f = element.F();
              const Response response = alone.advance({snapped(f * before.inverse())});
              REQUIRE(response.stable);
              alone.commit();
              worst = std::max(worst, (to_voigt(response.stress) - element.stress()).norm() / response.stress.norm());
              before = f;
              return true;
            }).converged);
    CHECK(worst < 1e-6);
    // Nothing is out of balance by more than Newton's tolerance or the RVE's noise, here three hundredths at most.
    if (triaxial) CHECK(std::abs(element.stress()[0] + 1e5) < 0.03 * 2e5);
    if (!triaxial) CHECK(element.rves.report().distinct == 1);  // sides under pressure follow the sample's own skewness
  }
}

TEST_CASE(
    "Hill-Mandel: the macro stresses' work on the deformation is the cell's work on the grains, in the limit of slow "
    "loading") {
  // What the cell does beyond the stresses at rest is the price of its rate: it goes with the inertial number.
  std::array<double, 2> off{};
  int k = 0;
  for (double inertial : {2e-3, 1e-4}) {
    Sand s = standard();
    s.q.inertial_number = inertial;
    Element element(s, {everywhere(shear(0.02))});
    double work = 0;
    REQUIRE(fem::solve_statics(element.problem, element.material, options(40), [&](const fem::IncrementReport& r) {
              work = r.energy.work;
              return true;
            }).converged);
    const dem::Facts& f = element.rves.facts(0);
    off[static_cast<std::size_t>(k++)] = 1 - work / (f.work / element.rves.start_volume(0));
    CHECK(f.energy_error < 1e-3);  // and that work is all in the ledger: stored, slid away or damped
  }
  CHECK(off[0] > 0);
  CHECK(std::abs(off[1]) < 0.01);  // the trapezoid over 40 increments
}

TEST_CASE("what is told of all points is told of this rank's alone, or of all ranks' where these have parts of them") {
  const Sand& s = standard();
  int ranks = 1, rank = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks), MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  for (const bool spread : {false, true}) {
    coupling::RveOptions with;
    with.response.quasi_static = s.q, with.exact_sharing = false;
    coupling::RveFarm farm(MPI_COMM_SELF, s.model, with.response, 1);
    coupling::RveMaterial rves(
        farm, {s.state}, {0, 0}, with, spread ? std::optional(MPI_COMM_WORLD) : std::nullopt,
        spread ? std::vector<std::int64_t>{2 * rank, 2 * rank + 1} : std::vector<std::int64_t>{});
    fem::Material m = rves.material();
    std::vector<double> f, stress(12), tangent(72);
    for (const double e : {1e-4 * (1 + rank), 2e-4}) f.insert(f.end(), {1, 0, 0, 0, 1, 0, 0, 0, 1 - e});
    REQUIRE(m.respond({f, stress, tangent}));
    m.commit();
    const auto of = static_cast<std::uint64_t>(spread ? ranks : 1);
    const coupling::SweepReport own = rves.report(), all = rves.report_of_all();
    CHECK((own.asked == 2 && own.advanced == 2 && own.distinct == 2 && own.dem_steps > 0));
    CHECK((all.asked == 2 * of && all.advanced == 2 * of && all.distinct == 2 * of));
    CHECK((all.dem_steps >= own.dem_steps && (of == 1) == (all.dem_steps == own.dem_steps)));
    CHECK(all.worst_unbalanced >= own.worst_unbalanced);
    CHECK(all.worst_unbalanced <= s.q.unbalanced_force);
    CHECK((all.deferred == 0 && all.given_up == 0 && all.least_trust == 1));
    CHECK(rves.count(&Facts::grains) == 2 * of * s.state.grains.size());
    CHECK(rves.sum([](const Facts& fact) { return fact.mass; }) ==
          Approx(2 * static_cast<double>(of) * total_mass(s.state.grains)).epsilon(1e-12));
    CHECK(rves.largest([&](const Facts&) { return 1.0 + rank; }) == static_cast<double>(spread ? ranks : 1 + rank));
    CHECK(rves.all_points() == 2 * of);
  }
}

TEST_CASE("objectivity: a stressed element turned by 90 degrees has its stress turned") {
  Mat3 u = Mat3::Identity();
  u(2, 2) -= 0.01, u(0, 1) = u(1, 0) = 0.004;
  Mat3 r;
  r << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  Element straight(standard(), {everywhere(u - Mat3::Identity())}),
      turned(standard(), {everywhere(r * u - Mat3::Identity())});
  REQUIRE(fem::solve_statics(straight.problem, straight.material, options(1), always).converged);
  REQUIRE(fem::solve_statics(turned.problem, turned.material, options(1), always).converged);
  const Mat3 expected = r * from_voigt(straight.stress()) * r.transpose();
  CHECK((from_voigt(turned.stress()) - expected).norm() < 1e-6 * expected.norm());
}

TEST_CASE(
    "similar sharing: points that leave replay their own path and then are as if they had never shared; its error is "
    "measured") {
  // Shear that grows with height: points part gradually. All nodes are prescribed, so both runs see the same
  // deformation.
  auto bent = everywhere(Mat3::Zero());
  bent.at = [](const Point& x) { return Point{2e-3 * x[2] * x[2] + 1e-3 * x[2], 0, -4e-3 * x[2]}; };
  bent.where = [](const Point&) { return true; };
  Element plain(standard(), {bent}, {}, {1, 1, 4});
  coupling::RveOptions with;
  with.share = 1.5e-3;
  Element shared(standard(), {bent}, with, {1, 1, 4});
  REQUIRE(fem::solve_statics(plain.problem, plain.material, options(8), always).converged);
  REQUIRE(fem::solve_statics(shared.problem, shared.material, options(8), always).converged);
  const auto& report = shared.rves.report();
  CHECK(report.replayed > 0);
  CHECK(report.similar > 0);
  CHECK(report.distinct < plain.rves.report().distinct);
  CHECK(report.dem_steps < plain.rves.report().dem_steps);
  std::size_t same = 0;
  double worst = 0;
  for (std::size_t i = 0; i < plain.problem.owned_points(); ++i) {
    const double off = (plain.stress(i) - shared.stress(i)).norm() / plain.stress(i).norm();
    same += plain.stress(i) == shared.stress(i);
    worst = std::max(worst, off);
  }
  CHECK(same >= report.distinct);  // every RVE belongs to a point whose own path it has had
  CHECK(worst > 0);
  CHECK(worst < 0.05);
  CHECK(report.sharing.count == report.replayed);
  CHECK(report.sharing.worst < 0.05);
}

TEST_CASE("deferral: fewer RVE runs, the error that it reports is the true one, and both stay under the tolerance") {
  const double tolerance = 0.05;
  Mat3 g = Mat3::Zero();
  g(2, 2) = -0.01, g(0, 0) = g(1, 1) = 0.003;
  coupling::RveOptions with;
  with.error = tolerance;
  Element plain(standard(), {everywhere(g)}), lazy(standard(), {everywhere(g)}, with);
  const double worst = worst_difference(plain, lazy, 100);
  const auto& report = lazy.rves.report();
  CHECK(report.deferred > 0);
  CHECK(static_cast<double>(report.advanced) < 0.8 * static_cast<double>(plain.rves.report().advanced));
  CHECK(report.deferral.count > 0);
  CHECK(report.deferral.worst < tolerance);
  CHECK(worst < 2 * tolerance);  // a path of other increments ends elsewhere too: within the RVE's own scatter
}

TEST_CASE(
    "elastic points: one linear response serves until contacts slide; its error is measured when the grains catch up") {
  Mat3 g = Mat3::Zero();
  g(2, 2) = -4e-3;
  coupling::RveOptions with;
  with.response.elastic = 0.02;
  Sand s = standard();
  s.q.unbalanced_force = s.q.stress_change = 1e-4;
  Element plain(s, {everywhere(g)}), linear(s, {everywhere(g)}, with);
  const double worst = worst_difference(plain, linear, 100);
  const auto& report = linear.rves.report();
  CHECK(report.elastic > 10);
  CHECK(report.advanced > 10);  // sliding sets in on the way
  CHECK(report.linear.count > 0);
  CHECK(report.linear.worst < 0.02);
  CHECK(worst < 0.03);
}

TEST_CASE(
    "an RVE that refuses an increment is taken in parts, then the increment is cut; the same with RVEs on another "
    "rank") {
  int rank, ranks;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  // The hold that a big and a small increment need: a limit between them refuses the big one, its quarter, and takes a
  // sixteenth.
  Sand s = standard();
  s.q.window = 10, s.q.inertial_number = 0.3, s.q.strain_per_step = 1e-3;
  const double big = -0.02;
  auto hold_after = [&](double strain) {
    State copy = s.state;
    Team team(1);
    Mat3 f = Mat3::Identity();
    f(2, 2) += strain;
    return deform(*s.model, s.q, copy, {f}, team).hold_steps;
  };
  std::uint64_t coarse = std::min(hold_after(big), hold_after(big / 4)), fine = hold_after(big / 16);
  INFO(hold_after(big) << " " << hold_after(big / 4) << " " << fine);
  REQUIRE(fine < coarse);
  s.q.max_hold = coarse - 1;
  coupling::RveOptions with;
  with.response.quasi_static = s.q;
  std::vector<std::vector<double>> stress;
  for (const MPI_Comm comm : {MPI_COMM_SELF, MPI_COMM_WORLD}) {
    if (rank > 0) {
      if (comm == MPI_COMM_WORLD) coupling::serve(comm, s.model, with.response, 1);
      continue;
    }
    coupling::RveFarm farm(comm, s.model, with.response, 1);
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 1}, true, {}}, {1, 2, true},
                         {everywhere(Vec3(0, 0, big).asDiagonal())});
    with.exact_sharing = false;
    coupling::RveMaterial rves(farm, {s.state}, std::vector<std::size_t>(problem.owned_points(), 0), with);
    fem::Material m = rves.material();
    int cutbacks = 0;
    fem::StaticsOptions o = options(1);
    o.max_cutbacks = 8;
    double reached = 0;
    std::string reason;
    const auto result = fem::solve_statics(problem, m, o, [&](const fem::IncrementReport& r) {
      cutbacks += r.cutbacks, reached = r.load_factor;
      if (!r.cut_reason.empty()) reason = r.cut_reason;
      return r.load_factor < 0.3;  // it goes on; later increments need not be seen
    });
    CHECK((result.converged || result.stopped));
    CHECK(cutbacks > 0);
    CHECK(reached > 0);
    CHECK(reason.find("not in equilibrium") != std::string::npos);
    CHECK(rves.report().retried > 0);
    stress.emplace_back(problem.stress().begin(), problem.stress().end());
    stress.back().push_back(static_cast<double>(rves.report().dem_steps));
  }
  if (rank == 0) CHECK((stress[0] == stress[1]));
}

TEST_CASE(
    "a wave in a bar of grains: simple cubic packing, c = sqrt(k / (d rho)), through explicit dynamics and RVEs in "
    "real time") {
  const double kn = 1e6, R = 5e-4, d = 2 * R * (1 - 1e-4), density = 2650;
  Model model = test::linear_model(kn, 0.8, density, 0.5);
  State s;
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 2; ++y)
      for (int z = 0; z < 2; ++z) test::add(s, PolyEllipsoid::sphere(R), d * Vec3(x, y, z), density);
  s.boundary.cell.vectors = 2 * d * Mat3::Identity();
  Team team(1);
  prepare(model, s, team);
  const auto shared = std::make_shared<const Model>(model);
  const double rho = total_mass(s.grains) / s.boundary.cell.volume(), c = std::sqrt(kn / d / rho), speed = 2e-5 * c,
               length = 0.5, duration = 0.6 * length / c;
  auto low = plane("low", 1, 0, 1, speed * duration);
  low.history.points = {{0, 0}, {duration, 1}};
  fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{0.01, length, 1}, {1, 40, 1}, true, {}},
                       {1, 1, true, fem::Kinematics::plane_strain, 1},
                       {low, plane("high", 1, length, 1, 0), plane("left", 0, 0, 0, 0), plane("right", 0, 0.01, 0, 0)});
  coupling::RveOptions with;
  with.pace = dem::Pace::real_time;
  coupling::RveFarm farm(MPI_COMM_SELF, shared, with.response, 2);
  coupling::RveMaterial rves(farm, {s}, std::vector<std::size_t>(problem.owned_points(), 0), with);
  fem::Material m = rves.material();
  fem::DynamicsOptions o;
  o.duration = duration, o.linear_viscosity = 0.06;
  const auto result = fem::solve_dynamics(problem, m, std::vector<double>(problem.owned_points(), rho), o,
                                          [](const fem::DynamicsReport&) { return true; });
  REQUIRE(result.finished);
  const double front = -problem.mean_strain()[1] / (speed / c);  // part of the bar that the wave has passed
  CHECK(front == Approx(0.6).epsilon(2e-2));
  std::vector<std::uint8_t> behind;
  for (std::size_t i = 0; i < problem.owned_points(); ++i)
    behind.push_back(problem.point_position(i)[1] > 0.1 * length && problem.point_position(i)[1] < 0.4 * length);
  CHECK(-problem.mean_strain(behind)[1] == Approx(speed / c).epsilon(2e-2));
  // The stiffness of the lattice is k / d, to the overlap; the prestress is k times the overlap over d^2.
  const double prestress = -kn * 2 * R * 1e-4 / (d * d);
  CHECK(problem.mean_stress(behind)[1] - prestress == Approx(-kn / d * speed / c).epsilon(3e-2));
  CHECK(std::abs(result.last.energy.error()) < 1e-2);
}

TEST_CASE("points start with the symmetric stiffness of their own network; a state without contacts is refused") {
  const Sand &one = standard(), other = sand(5);
  const auto found =
      coupling::start_stiffness(*one.model, {one.state, other.state}, std::array<std::size_t, 3>{1, 0, 1});
  REQUIRE(found.size() == 3);
  CHECK((found[0] == found[2] && found[0] != found[1]));
  for (const auto& [at, state] : {std::pair{0u, &other.state}, {1u, &one.state}}) {
    const Mat6 network = network_tangent(*one.model, *state), even = 0.5 * (network + network.transpose());
    for (int k = 0; k < 36; ++k) CHECK(found[at][static_cast<std::size_t>(k)] == Approx(even(k / 6, k % 6)).margin(1));
    CHECK(even(0, 0) > 1e6);
  }
  State apart;
  test::add(apart, PolyEllipsoid::sphere(5e-3), Vec3::Zero(), 2650);
  apart.boundary.cell.vectors = 0.05 * Mat3::Identity();
  Team team(1);
  prepare(*one.model, apart, team);
  CHECK_THROWS_AS(coupling::start_stiffness(*one.model, {apart}, std::array<std::size_t, 1>{0}), InputError);
}

}  // namespace grus
