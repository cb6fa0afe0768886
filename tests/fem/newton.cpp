// SPDX-License-Identifier: LGPL-3.0-or-later
// Newton's increments: predictor, better tangents, mixing, line search, what counts as balance, by bars under traction.
#include "fem/statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/helpers.hpp"

namespace grus {  // headers of DOLFINx bring another `fem` into the global space

using fem::Point;
using fem::test::plane;

namespace {

bool always(const fem::IncrementReport&) { return true; }

fem::StaticsOptions options(int increments, double tolerance, double displacement) {
  fem::StaticsOptions o;
  o.increments = increments, o.tolerance = tolerance, o.displacement_tolerance = displacement;
  return o;
}

/// The top of a bar of unit height, under 100 kPa upwards.
fem::BoundaryCondition pulled() {
  fem::BoundaryCondition b;
  b.name = "top", b.where = [](const Point& x) { return std::abs(x[2] - 1) < 1e-9; }, b.traction = Point{0, 0, 1e5};
  return b;
}

std::vector<fem::BoundaryCondition> held_low_and(const fem::BoundaryCondition& top) {
  return {plane("x0", 0, 0, 0, 0), plane("y0", 1, 0, 1, 0), plane("z0", 2, 0, 2, 0), top};
}

/// An elastic solid (100 MPa, 0.2) that tells this many times its tangent.
fem::Material with_tangent_times(double factor, const fem::Problem& problem) {
  const fem::Material elastic = fem::elastic_material(problem.owned_points(), 1e8, 0.2);
  fem::Material m = elastic;
  m.respond = [elastic, factor](const fem::Points& p) {
    if (!elastic.respond(p)) return false;
    for (double& c : p.tangent) c *= factor;
    return true;
  };
  return m;
}

}  // namespace

TEST_CASE(
    "the last increment foretells the next, unless the load turns: a tangent four times too stiff costs no more") {
  fem::BoundaryCondition pull = pulled();
  pull.history.points = {{0, 0}, {0.5, 1}, {1, 0.5}};
  for (const double too_stiff : {1.0, 4.0}) {
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 2}, true, {}}, {1, 2, false},
                         held_low_and(pull));
    fem::Material m = with_tangent_times(too_stiff, problem);
    std::vector<double> first;  // residual of each predictor
    const auto result = fem::solve_statics(problem, m, options(8, 1e-10, 1e-9), [&](const fem::IncrementReport& r) {
      return first.push_back(r.residuals.front()), true;
    });
    REQUIRE(result.converged);
    REQUIRE(first.size() == 8);
    // Increments 1 and 5 go by the tangent, a part of the way; forces in and out at the top, in at the base.
    const auto off = [&](double from, double to) {
      const double in = from + (to - from) / too_stiff;
      return std::abs(to - in) / std::sqrt(to * to + 2 * in * in);
    };
    CHECK(first[0] == Approx(off(0, 0.25)).margin(1e-8));
    CHECK(first[4] == Approx(off(1, 0.875)).margin(1e-8));
    for (const std::size_t k : {1u, 2u, 3u, 5u, 6u, 7u}) CHECK(first[k] < 1e-8);
    CHECK(problem.mean_strain()[2] == Approx(0.5e-3).epsilon(1e-7));
  }
  // Increments that grow by half foretell one another, too.
  fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 2}, true, {}}, {1, 2, false},
                       held_low_and(pulled()));
  fem::Material m = with_tangent_times(4, problem);
  fem::StaticsStart small;
  small.next_size = 0.02;
  double last = 0, least = 1, most = 0;
  const auto watch = [&](const fem::IncrementReport& r) {
    if (r.increment > 1) CHECK(r.residuals.front() < 1e-8);
    least = std::min(least, r.load_factor - last), most = std::max(most, r.load_factor - last);
    return last = r.load_factor, true;
  };
  REQUIRE(fem::solve_statics(problem, m, options(4, 1e-10, 1e-9), watch, small).converged);
  CHECK(most > 5 * least);
}

TEST_CASE("an iterative linear solver finds what factors find, in few iterations, on any number of ranks") {
  struct Found {
    std::array<double, 6> stress;
    double pressed;
    int newton = 0, linear = 0, failures = 0;
  };
  const auto find = [](fem::LinearMethod method, int cells, double yield) {
    // A slender bar whose end is bent down by a tenth of its height; it yields, or does not.
    fem::Problem problem(MPI_COMM_WORLD, fem::BoxMesh{{8, 1, 1}, {8 * cells, cells, cells}, true, {}}, {1, 2, false},
                         {plane("wall", 0, 0, 0, 0), plane("wall y", 0, 0, 1, 0), plane("wall z", 0, 0, 2, 0),
                          plane("end", 0, 8, 2, -0.1)});
    fem::Material m = fem::j2_material(problem.owned_points(), 1e8, 0.2, yield, 1e7);
    fem::StaticsOptions o = options(2, 1e-7, 1e-7);
    o.linear = method;
    Found found;
    const auto result = fem::solve_statics(problem, m, o, [&](const fem::IncrementReport& r) {
      found.newton += r.iterations, found.linear += r.linear_iterations, found.failures += r.linear_failures;
      return true;
    });
    REQUIRE(result.converged);
    found.stress = problem.mean_stress(), found.pressed = problem.mean_displacement(3)[2];
    return found;
  };
  using enum fem::LinearMethod;
  const Found by_factors = find(direct, 2, 1e5), by_iterations = find(iterative, 2, 1e5);
  CHECK((by_factors.linear == 0 && by_factors.failures == 0 && by_iterations.failures == 0));
  CHECK(by_iterations.newton <= by_factors.newton + 1);         // slender: 1e-9 of the motion is more of the force
  CHECK(by_iterations.pressed == Approx(-0.1).epsilon(1e-14));  // what is prescribed is known, not found
  double largest = 0;
  for (const double s : by_factors.stress) largest = std::max(largest, std::abs(s));
  for (std::size_t k = 0; k < 6; ++k)
    CHECK(by_iterations.stress[k] == Approx(by_factors.stress[k]).margin(1e-7 * largest));
  // Elastic: a solve for each of the two increments, and one that finds nothing left to do.
  const Found coarse = find(iterative, 2, 1e9), fine = find(iterative, 4, 1e9);
  INFO(coarse.linear << " iterations, " << fine.linear << " on a mesh of half the size");
  CHECK((coarse.failures == 0 && fine.failures == 0));
  // Nearer to no growth than to that of 1 / h; without rigid motions told 1.46 times.
  CHECK(fine.linear < std::sqrt(2.0) * coarse.linear);
}

TEST_CASE("an increment that fails is begun once more with the better tangent before it is cut") {
  fem::BoundaryCondition pull = pulled();
  for (const bool has_better : {true, false}) {
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 2}, true, {}}, {1, 2, false},
                         held_low_and(pull));
    fem::Material elastic = fem::elastic_material(problem.owned_points(), 1e9, 0.0), m = elastic;
    int asked = 0;
    m.respond = [&](const fem::Points& p) {  // thirty times too stiff until asked
      const bool good = elastic.respond(p);
      for (double& c : p.tangent) c *= asked > 0 && has_better ? 1 : 30;
      return good;
    };
    m.sharpen = [&] { return ++asked == 1 && has_better; };
    auto o = options(2, 1e-8, 1e-6);
    o.acceleration = 0, o.max_iterations = 10, o.max_cutbacks = 1;
    int cutbacks = 0;
    const auto result =
        fem::solve_statics(problem, m, o, [&](const fem::IncrementReport& r) { return cutbacks += r.cutbacks, true; });
    CHECK(result.converged == has_better);
    if (has_better) CHECK(cutbacks == 0);
    CHECK(asked == (has_better ? 1 : 2));
  }
}

TEST_CASE(
    "a correction that is still large is made, however small the residual; Anderson's mixing needs a few of them") {
  // A tangent three times too stiff: each step leaves two thirds, 34 of them a millionth. Residuals are judged by
  // nothing here.
  fem::BoundaryCondition pull = pulled();
  for (const int remembered : {0, 5}) {
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 1}, true, {}}, {1, 2, false},
                         held_low_and(pull));
    fem::Material m = with_tangent_times(3, problem);
    fem::StaticsOptions o = options(1, 1, 1e-6);
    o.acceleration = remembered, o.max_iterations = 60;
    int iterations = 0;
    const auto count = [&](const fem::IncrementReport& r) { return iterations = r.iterations, true; };
    REQUIRE(fem::solve_statics(problem, m, o, count).converged);
    CHECK(problem.mean_strain()[2] == Approx(1e-3).epsilon(1e-5));
    CHECK((remembered > 0 ? iterations < 12 : iterations > 25));
  }
}

TEST_CASE("steps that overshoot are cut: by the line search, and to what was moved so far") {
  fem::BoundaryCondition pull = pulled();
  {  // A tangent four times too soft: each full step leaves three times the error of the one before.
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 1}, true, {}}, {1, 2, false},
                         held_low_and(pull));
    fem::Material m = with_tangent_times(0.25, problem);
    fem::StaticsOptions o = options(1, 1e-8, 1e-6);
    o.acceleration = 0, o.max_iterations = 60;
    REQUIRE(fem::solve_statics(problem, m, o, always).converged);
    CHECK(problem.mean_strain()[2] == Approx(1e-3).epsilon(1e-6));
  }
  // A tangent that collapses: corrections of a thousand times the increment are proposed, none goes further than the
  // way so far.
  fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 2}, true, {}}, {1, 2, false},
                       held_low_and(plane("top", 2, 1, 2, 1e-3)));
  fem::Material elastic = fem::elastic_material(problem.owned_points(), 1e8, 0.2), m = elastic;
  double furthest = 0;
  int asked = 0;
  m.respond = [&](const fem::Points& p) {
    if (!elastic.respond(p)) return false;
    for (std::size_t i = 0; i < problem.owned_points(); ++i) {
      for (std::size_t k = 0; k < 9; ++k)
        furthest = std::max(furthest, std::abs(p.deformation[9 * i + k] - (k % 4 == 0 ? 1 : 0)));
      if (asked > 0 && problem.point_position(i)[2] > 0.5) p.stress[6 * i + 2] *= 0.9;  // out of balance
    }
    if (++asked > 1)
      for (double& c : p.tangent) c *= 1e-4;
    return true;
  };
  fem::StaticsOptions o = options(1, 1e-8, 1e-6);
  o.max_iterations = 1, o.max_cutbacks = 0, o.acceleration = 0;
  CHECK_FALSE(fem::solve_statics(problem, m, o, always).converged);
  CHECK(asked > 2);
  CHECK(furthest < 5e-3);  // twice the way, in half of the length
}

TEST_CASE("where nearly all force is gone, what is left need not balance better than a share of what there was") {
  fem::BoundaryCondition pull = pulled();
  pull.history.points = {{0, 0}, {0.5, 1}, {1, 0}};
  fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 2}, true, {}}, {1, 2, false}, held_low_and(pull));
  fem::Material elastic = fem::elastic_material(problem.owned_points(), 1e8, 0.2), m = elastic;
  int asked = 0;
  m.respond =
      [&](const fem::Points& p) {  // a material with a noise of 1e-4 of the largest stress, never twice the same
        if (!elastic.respond(p)) return false;
        ++asked;
        for (std::size_t i = 0; i < problem.owned_points(); ++i)
          p.stress[6 * i + 2] += 10 * std::sin(1.7 * asked + (problem.point_position(i)[2] > 0.5 ? 2 : 0));
        return true;
      };
  fem::StaticsOptions o = options(4, 1e-2, 1e-1);
  o.max_cutbacks = 1;
  REQUIRE(fem::solve_statics(problem, m, o, always).converged);
  CHECK(std::abs(problem.mean_stress()[2]) < 100);
}

}  // namespace grus
