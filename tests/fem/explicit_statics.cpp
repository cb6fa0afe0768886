// SPDX-License-Identifier: LGPL-3.0-or-later
// Quasi-static problems without iterations: against closed forms and Newton, masses, balance, rate, weight, own
// stresses, RVEs.
#include "fem/problem_impl.hpp"

#include "coupling/rve_material.hpp"
#include "dem/base/random.hpp"
#include "fem/central_differences.hpp"
#include "fem/explicit_statics.hpp"
#include "fem/statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/fem/hyperelastic.hpp"
#include "tests/fem/sand.hpp"

namespace grus {  // DOLFINx has a namespace fem, too
namespace {

using fem::ElementKind;
using fem::ExplicitStaticsOptions;
using fem::ExplicitStaticsReport;
using fem::Kinematics;
using fem::Point;
using fem::test::hyperelastic;
using fem::test::plane;

constexpr double E = 1e8, nu = 0.25;

const auto go_on = [](const ExplicitStaticsReport&) { return true; };

/// A block on a clamped base whose top is pushed down and aside; elements of different sizes.
fem::Problem pushed(double by, ElementKind element = ElementKind::standard) {
  fem::BoxMesh mesh{{1, 1, 1}, {4, 6, 1}, true, {}};
  mesh.map = [](const Point& x) { return Point{x[0], x[1] * (0.4 + 0.6 * x[1]), 0}; };
  auto base = plane("base", 1, 0, 0, 0), top = plane("top", 1, 1, 1, -by);
  base.displacement[1] = 0, top.displacement[0] = 0.3 * by;
  return fem::Problem(MPI_COMM_SELF, mesh, {1, 2, true, Kinematics::plane_strain, 1, element}, {base, top});
}

std::vector<double> displacements(fem::Problem& p) { return {p.impl().u->array().begin(), p.impl().u->array().end()}; }

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0, all = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]), all += b[i] * b[i];
  return std::sqrt(sum / all);
}

double eigenvalue(const fem::Problem::Impl& p, std::int32_t c, double density) {
  return fem::largest_eigenvalue(fem::stiffness_over_mass(p, c, [&](std::size_t) { return density; }));
}

/// What gives an element the common step.
double wanted_density(const fem::Problem::Impl& p, std::int32_t c, const ExplicitStaticsOptions& o) {
  return eigenvalue(p, c, 1) * (1 + o.damping) / (4 * o.safety * o.safety);
}

}  // namespace

TEST_CASE(
    "a hyperelastic block ends where Newton ends, at rest, with its energy accounted for, in few steps or in many") {
  for (const auto element : {ElementKind::standard, ElementKind::fbar}) {
    fem::Problem by_newton = pushed(0.1, element), by_steps = pushed(0.1, element);
    fem::Material a = hyperelastic(by_newton.owned_points(), 4e7, 4e7),
                  b = hyperelastic(by_steps.owned_points(), 4e7, 4e7);
    fem::StaticsOptions newton;
    newton.increments = 5, newton.tolerance = 1e-9;
    REQUIRE(fem::solve_statics(by_newton, a, newton, [](const fem::IncrementReport&) { return true; }).converged);
    ExplicitStaticsOptions o;
    o.balance = 1e-3;
    const auto result = fem::solve_explicit_statics(by_steps, b, o, go_on);
    REQUIRE(result.finished);
    const auto& e = result.last.energy;
    CHECK(distance(displacements(by_steps), displacements(by_newton)) < 2e-3);
    for (int k : {0, 1})
      CHECK(by_steps.reaction(1)[static_cast<std::size_t>(k)] ==
            Approx(by_newton.reaction(1)[static_cast<std::size_t>(k)]).epsilon(5e-3));
    CHECK(e.kinetic < 1e-4 * e.internal);
    CHECK(e.damped > 0);
    CHECK(std::abs(e.error()) < 2e-3);
    CHECK(e.work == Approx(e.internal).epsilon(5e-3));  // Hill and Mandel; the energy is a step behind
  }
}

TEST_CASE("masses give every element the same critical step, and no element that softens loses any") {
  fem::Problem problem = pushed(0.05);
  fem::Material m = hyperelastic(problem.owned_points(), 4e7, 4e7);
  ExplicitStaticsOptions o;
  o.safety = 0.7;
  std::vector<double> before;
  bool falls = false, grows = false;
  const auto result = fem::solve_explicit_statics(problem, m, o, [&](const ExplicitStaticsReport&) {
    const auto& rho = problem.impl().of_cells.at("scaled density");
    for (std::size_t c = 0; c < before.size(); ++c)
      falls = falls || rho[c] < before[c], grows = grows || rho[c] > before[c];
    before = rho;
    return true;
  });
  REQUIRE(result.finished);
  CHECK_FALSE(falls);
  CHECK(grows);  // compressed elements stiffen
  // What cannot be the largest eigenvalue so far is not found, and what is counts in the same step.
  fem::Problem looked_at = pushed(0.05);
  fem::Material alike = hyperelastic(looked_at.owned_points(), 4e7, 4e7);
  auto often = o;
  often.estimate_every = 1, often.output_interval = 1, often.balance = often.kinetic = 1e6;
  int steps = 0, largest = 0;
  double above = 0;
  often.stop = [&] {
    auto& impl = looked_at.impl();
    for (std::int32_t c = 0; c < impl.cells; ++c) {
      const double ratio = wanted_density(impl, c, o) / impl.of_cells.at("scaled density")[static_cast<std::size_t>(c)];
      above = std::max(above, ratio - 1), largest += std::abs(ratio - 1) < 1e-12 ? 1 : 0;
    }
    return ++steps == 300;
  };
  REQUIRE(fem::solve_explicit_statics(looked_at, alike, often, go_on).stopped);
  CHECK(above < 1e-12);
  CHECK(largest > steps);
  // Pulled, they soften: to some 2/3 of the eigenvalue at a stretch of 1.3.
  fem::Problem pulled = pushed(-0.3);
  fem::Material soft = hyperelastic(pulled.owned_points(), 4e7, 4e7);
  std::vector<double> first;
  bool softened = false, lost = false;
  REQUIRE(fem::solve_explicit_statics(pulled, soft, o, [&](const ExplicitStaticsReport&) {
            auto& impl = pulled.impl();
            if (first.empty()) first = impl.of_cells.at("scaled density");
            for (std::int32_t c = 0; c < impl.cells; ++c) {
              const double held = impl.of_cells.at("scaled density")[static_cast<std::size_t>(c)];
              const double wanted = wanted_density(impl, c, o);
              softened = softened || wanted < 0.95 * held;
              lost = lost || held < first[static_cast<std::size_t>(c)];
            }
            return true;
          }).finished);
  CHECK(softened);
  CHECK_FALSE(lost);
  // At the start: 2 / omega = 1 / safety for each element by itself.
  fem::Problem fresh = pushed(0.05);
  fem::Material same = hyperelastic(fresh.owned_points(), 4e7, 4e7);
  auto once = o;
  once.stop = [] { return true; };
  REQUIRE(fem::solve_explicit_statics(fresh, same, once, go_on).stopped);
  const auto& p = fresh.impl();
  fem::Problem unmoved = pushed(0.05);
  fem::Material probe = hyperelastic(unmoved.owned_points(), 4e7, 4e7);
  auto& q = unmoved.impl();
  REQUIRE(q.strain_sweep());
  REQUIRE(probe.respond({q.deformation, q.stress, q.tangent}));
  for (std::int32_t c = 0; c < p.cells; ++c) {
    const double rho = p.of_cells.at("scaled density")[static_cast<std::size_t>(c)];
    CHECK(2 / std::sqrt(eigenvalue(q, c, rho)) == Approx(std::sqrt(1 + o.damping) / o.safety).epsilon(1e-9));
  }
}

TEST_CASE("stress that flickers does not hold a load back: what is pushed in at the top comes out at the base") {
  fem::BoxMesh mesh{{1, 1, 1}, {4, 8, 1}, true, {}};
  auto base = plane("base", 1, 0, 1, 0), top = plane("top", 1, 1, 1, -0.05);
  fem::Problem problem(MPI_COMM_SELF, mesh, {1, 2, true, Kinematics::plane_strain, 1}, {base, top});
  fem::Material m = hyperelastic(problem.owned_points(), 4e7, 4e7);
  std::uint64_t asked = 0;
  m.respond = [&, smooth = m.respond](const fem::Points& points) {
    const bool good = smooth(points);
    ++asked;
    for (std::size_t i = 0; i < points.stress.size() / 6; ++i) {  // a draw for each element and twenty steps
      const double draw = dem::random_uniform(7, i / 4, dem::Purpose::orientation, asked / 20) - 0.5;
      for (std::size_t k = 0; k < 3; ++k) points.stress[6 * i + k] += 4e5 * draw;
    }
    return good;
  };
  ExplicitStaticsOptions o;
  o.max_energy_error = INFINITY, o.balance = 1, o.kinetic = 1;  // the draws' work is nobody's
  double in = 0, out = 0;
  REQUIRE(fem::solve_explicit_statics(problem, m, o, [&](const ExplicitStaticsReport& r) {
            if (r.load_factor > 0.3 && r.load_factor < 0.95)
              in -= problem.reaction(1)[1], out += problem.reaction(0)[1];
            return true;
          }).finished);
  INFO("in " << in << ", out " << out);
  CHECK(out == Approx(in).epsilon(0.005));
}

TEST_CASE("a material that tells less energy than it was given ends the run: the balance can fail") {
  for (const double told : {1.0, 1.3}) {
    fem::Problem problem = pushed(0.05);
    fem::Material m = hyperelastic(problem.owned_points(), 4e7, 4e7, told);
    ExplicitStaticsOptions o;
    const auto result = fem::solve_explicit_statics(problem, m, o, go_on);
    CHECK(result.finished == (told == 1));
    if (told != 1) CHECK(result.failure.find("energy error") != std::string::npos);
  }
}

TEST_CASE(
    "the rate keeps the unbalanced force and the kinetic energy within their limits, and a balance that cannot be held "
    "ends the run") {
  const auto run = [](double balance, double kinetic, double crossings) {
    fem::Problem problem = pushed(0.05);
    fem::Material m = hyperelastic(problem.owned_points(), 4e7, 4e7);
    ExplicitStaticsOptions o;
    o.balance = balance, o.kinetic = kinetic, o.crossings = crossings;
    double worst = 0, moving = 0;
    auto result = fem::solve_explicit_statics(problem, m, o, [&](const ExplicitStaticsReport& r) {
      if (r.load_factor > 0.1 && r.load_factor < 0.95)  // while what the start has stirred up dies away
        worst = std::max(worst, r.unbalanced), moving = std::max(moving, r.energy.kinetic_over_internal());
      return true;
    });
    return std::tuple(result, worst, moving);
  };
  const auto [easy, off, fast] = run(0.5, 0.5, 100);
  const auto [balanced, less_off, unused] = run(0.5 * off, 0.5, 100);
  const auto [slow, unused2, less_fast] = run(0.5, 0.3 * fast, 100);
  INFO(easy.failure << balanced.failure << slow.failure);
  REQUIRE((easy.finished && balanced.finished && slow.finished));
  CHECK(easy.last.governor == fem::Governor::none);
  CHECK(static_cast<double>(balanced.last.steps) > 1.3 * static_cast<double>(easy.last.steps));
  CHECK(less_off < 0.8 * off);  // half of it, and the rate follows some tens of steps behind
  CHECK(static_cast<double>(slow.last.steps) > 1.3 * static_cast<double>(easy.last.steps));
  CHECK(less_fast < 0.5 * fast);
  // Nothing holds a pressure at the start that no stress answers, where nothing can move to answer it.
  fem::Problem problem = pushed(0.05);
  fem::Material m = hyperelastic(problem.owned_points(), 4e7, 4e7);
  int calls = 0;
  const auto noisy = m.respond;
  m.respond = [&](const fem::Points& points) {  // a material that is never at rest
    const bool good = noisy(points);
    ++calls;
    for (std::size_t i = 0; i < points.stress.size(); ++i)
      points.stress[i] += 3e5 * std::sin(static_cast<double>(calls) * (1.0 + 0.37 * static_cast<double>(i)));
    return good;
  };
  ExplicitStaticsOptions o;
  o.balance = 1e-4, o.max_energy_error = INFINITY;
  const auto never = fem::solve_explicit_statics(problem, m, o, go_on);
  CHECK_FALSE(never.finished);
  CHECK(never.failure.find("balance") != std::string::npos);
}

TEST_CASE(
    "at the full step a block stays at rest for as long as one likes; beyond it round-off grows: local damping adds to "
    "the stiffness") {
  for (const double safety : {1.0, 1.1}) {
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {2, 4, 1}, true, {}},
                         {1, 2, true, Kinematics::plane_strain, 1},
                         {plane("base", 1, 0, 1, 0), plane("left", 0, 0, 0, 0)});
    problem.set_gravity({0, -10, 0}, std::vector<double>(problem.owned_points(), 2000));
    fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
    ExplicitStaticsOptions o;
    o.safety = safety, o.balance = 0.5, o.max_energy_error = INFINITY, o.crossings = 400;
    const auto result = fem::solve_explicit_statics(problem, m, o, go_on);
    CHECK(result.finished == (safety == 1));
    if (result.finished) CHECK(result.last.unbalanced < 1e-6);
  }
}

TEST_CASE(
    "a wall of earth under its weight: with the stress of the ground nothing moves, without it settles by rho g H^2 / "
    "2 M") {
  const double rho = 2000, g = 10, H = 2, M = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)), k0 = nu / (1 - nu);
  for (const bool ground : {true, false}) {
    fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{1, H, 1}, {2, 8, 1}, true, {}},
                         {1, 2, true, Kinematics::plane_strain, 1},
                         {plane("base", 1, 0, 1, 0), plane("left", 0, 0, 0, 0), plane("right", 0, 1, 0, 0)});
    problem.set_gravity({0, -g, 0}, std::vector<double>(problem.owned_points(), rho));
    fem::InitialStress initial;
    for (std::size_t i = 0; ground && i < problem.owned_points(); ++i) {
      const double v = -rho * g * (H - problem.point_position(i)[1]);
      initial.push_back({k0 * v, v, k0 * v, 0, 0, 0});
    }
    fem::Material m = fem::elastic_material(problem.owned_points(), E, nu, initial);
    ExplicitStaticsOptions o;
    o.max_energy_error = INFINITY, o.balance = 1e-4;  // nothing is loaded but by weight: no work to compare with
    const auto result = fem::solve_explicit_statics(problem, m, o, go_on);
    INFO(result.failure);
    REQUIRE(result.finished);
    double top = 0;
    const auto fields = problem.gather_fields();
    for (std::size_t n = 0; n < fields.nodes.size(); ++n)
      if (fields.nodes[n][1] > H - 1e-9) top = fields.displacement[n][1];
    const double settlement = rho * g * H * H / (2 * M);
    if (ground)
      CHECK(std::abs(top) < 1e-3 * settlement);
    else
      CHECK(top == Approx(-settlement).epsilon(2e-3));
    CHECK(problem.reaction(0)[1] == Approx(rho * g * H).epsilon(1e-3));
    for (std::size_t i = 0; i < problem.owned_points(); ++i)
      CHECK(problem.stress()[6 * i + 1] == Approx(-rho * g * (H - problem.point_position(i)[1]))
                                               .margin(0.04 * rho * g * H));  // constant over an element, H / 8 high
  }
}

TEST_CASE(
    "initial stress turns with the body and counts in its energy; beyond the yield stress a J2 solid flows from it") {
  const fem::InitialStress initial{{1e5, 0, 0, 0, 0, 0}};
  for (const bool plastic : {false, true}) {
    fem::Material m =
        plastic ? fem::j2_material(1, E, nu, 2e5, 1e6, initial) : fem::elastic_material(1, E, nu, initial);
    std::vector<double> f{0, -1, 0, 1, 0, 0, 0, 0, 1}, stress(6), tangent(36);
    REQUIRE(m.respond({f, stress, tangent}));
    CHECK(stress[1] == Approx(1e5));
    CHECK(std::abs(stress[0]) < 1e-6);
    // Stretch along the turned axis in small steps: energy is the sum of stress times strain.
    double work = 0, before = stress[1];
    m.commit();
    const std::vector<double> one{1};
    const double start = m.energy(one);
    for (int k = 0; k < 400; ++k) {
      f = {1, 0, 0, 0, 1 + 1e-5, 0, 0, 0, 1};
      REQUIRE(m.respond({f, stress, tangent}));
      m.commit();
      work += 0.5 * (before + stress[1]) * 1e-5 *
              std::pow(1 + 1e-5, k);  // nominal stress of a body that does not move sideways
      before = stress[1];
    }
    CHECK(m.energy(one) - start == Approx(work).epsilon(2e-3));
    if (plastic)
      CHECK(stress[1] - stress[0] < 2.2e5);
    else
      CHECK(stress[1] - stress[0] == Approx(1e5 + E / (1 + nu) * 4e-3).epsilon(3e-3));
  }
}

TEST_CASE("a block of grains: the explicit answer is Newton's, and it goes on from a checkpoint with the same bits") {
  const fem::test::Sand& sand = fem::test::standard();
  const auto block = [] {
    auto top = plane("top", 2, 1, 2, -0.01);
    return std::make_unique<fem::Problem>(
        MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 2}, true, {}}, fem::Discretisation{1, 2, true},
        std::vector<fem::BoundaryCondition>{top, plane("base", 2, 0, 2, 0), plane("x0", 0, 0, 0, 0),
                                            plane("x1", 0, 1, 0, 0), plane("y0", 1, 0, 1, 0), plane("y1", 1, 1, 1, 0)});
  };
  coupling::RveOptions slow;
  slow.response.quasi_static = sand.q;
  const auto newton = block();
  coupling::RveFarm farm(MPI_COMM_SELF, sand.model, slow.response, 1);
  coupling::RveMaterial relaxed(farm, {sand.state}, std::vector<std::size_t>(newton->owned_points(), 0), slow);
  fem::Material by_newton = relaxed.material();
  fem::StaticsOptions increments;
  increments.increments = 5, increments.tolerance = 1e-2;
  REQUIRE(
      fem::solve_statics(*newton, by_newton, increments, [](const fem::IncrementReport&) { return true; }).converged);

  coupling::RveOptions with = slow;
  with.pace = dem::Pace::steady;
  ExplicitStaticsOptions o;
  o.output_interval = 0.1;
  const auto whole = block(), part = block();
  coupling::RveFarm farm2(MPI_COMM_SELF, sand.model, with.response, 1),
      farm3(MPI_COMM_SELF, sand.model, with.response, 2);
  coupling::RveMaterial first(farm2, {sand.state}, std::vector<std::size_t>(whole->owned_points(), 0), with);
  fem::Material m = first.material();
  const auto result = fem::solve_explicit_statics(*whole, m, o, go_on);
  REQUIRE(result.finished);
  CHECK(whole->mean_stress()[2] == Approx(newton->mean_stress()[2]).epsilon(0.03));  // rate and rest of 60 grains
  CHECK(std::abs(result.last.energy.error()) < 0.01);
  first.refresh();
  std::vector<double> volumes(whole->owned_points(), 2.0 / 16);
  CHECK(first.total(&dem::Facts::haste, volumes) > 0);  // dashpots take

  // Stopped after some steps, saved, and gone on with by another set of the same.
  std::string bytes;
  fem::Snapshot snapshot;
  ExplicitStaticsReport at;
  {
    const auto stopped = block();
    coupling::RveMaterial rves(farm3, {sand.state}, std::vector<std::size_t>(stopped->owned_points(), 0), with);
    fem::Material half = rves.material();
    int steps = 0;
    auto some = o;
    some.stop = [&] { return ++steps > 100; };
    const auto until = fem::solve_explicit_statics(*stopped, half, some, go_on);
    REQUIRE(until.stopped);
    at = until.last, bytes = half.save(), snapshot = stopped->snapshot();
  }
  coupling::RveFarm farm4(MPI_COMM_SELF, sand.model, with.response, 2);
  coupling::RveMaterial again(farm4, {sand.state}, std::vector<std::size_t>(part->owned_points(), 0), with);
  fem::Material rest = again.material();
  part->restore(snapshot);
  rest.load(bytes);
  const auto end = fem::solve_explicit_statics(*part, rest, o, go_on, at);
  REQUIRE(end.finished);
  CHECK(end.last.steps == result.last.steps);
  CHECK(displacements(*part) == displacements(*whole));
  CHECK(end.last.energy.internal == result.last.energy.internal);
  CHECK(part->mean_stress() == whole->mean_stress());
}

}  // namespace grus
