// SPDX-License-Identifier: LGPL-3.0-or-later
// Rules of the quasi-static steps one by one: how long a wave takes, how the load goes on, waits and rests, what rules
// its rate, what scaled masses put in, what damping and the first velocity do.
#include <numeric>

#include "fem/problem_impl.hpp"

#include "fem/central_differences.hpp"
#include "fem/explicit_statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/fem/hyperelastic.hpp"
#include "tests/helpers.hpp"

namespace grus {  // DOLFINx has a namespace fem, too
namespace {

using fem::ExplicitStaticsOptions;
using fem::ExplicitStaticsReport;
using fem::Kinematics;
using fem::Point;
using fem::test::plane;

constexpr double E = 1e8, nu = 0.25;

const auto go_on = [](const ExplicitStaticsReport&) { return true; };

/// A confined column of unit height whose top is pushed down: every element is strained alike.
fem::Problem column(double by, int cells = 4, const fem::LoadHistory& history = {}) {
  auto base = plane("base", 1, 0, 1, 0), top = plane("top", 1, 1, 1, -by);
  top.history = history;
  return fem::Problem(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, cells, 1}, true, {}},
                      {1, 2, true, Kinematics::plane_strain, 1},
                      {base, top, plane("left", 0, 0, 0, 0), plane("right", 0, 1, 0, 0)});
}

ExplicitStaticsOptions free_of_limits() {
  ExplicitStaticsOptions o;
  o.balance = o.kinetic = 1e6, o.max_energy_error = INFINITY;
  return o;
}

/// How far the top has come down (m), now.
double moved(fem::Problem& problem) {
  double most = 0;
  for (const double u : problem.impl().u->array()) most = std::max(most, -u);
  return most;
}

}  // namespace

TEST_CASE("a chain of springs has no eigenvalue above a limit: told where it has none, by the closed form") {
  constexpr int n = 24;
  fem::Problem::Impl::Matrix chain = 2 * fem::Problem::Impl::Matrix::Identity(n, n);
  for (int i = 1; i < n; ++i) chain(i, i - 1) = chain(i - 1, i) = -1;
  const double largest = 2 + 2 * std::cos(M_PI / (n + 1));
  CHECK(fem::all_below(chain, largest * (1 + 1e-8)));
  CHECK_FALSE(fem::all_below(chain, largest));
  CHECK_FALSE(fem::all_below(chain, largest * (1 - 1e-8)));
  CHECK((fem::eigenvalue_above(4, chain) == 0 && fem::eigenvalue_above(3.9, chain) == Approx(largest).epsilon(1e-14)));
  CHECK_FALSE((fem::all_below(-chain, 0) || fem::all_below(NAN * chain, 1)));
}

TEST_CASE("a wave crosses a strip in as many steps as it has elements along, in two dimensions and in three") {
  ExplicitStaticsOptions o;
  o.safety = 0.8, o.damping = 0.5;
  for (const std::size_t along : {0u, 1u}) {
    Point size{1, 1, 1};
    std::array<long, 3> cells{2, 2, 2};
    size[along] = 10, cells[along] = 20;
    fem::Problem solid(MPI_COMM_SELF, fem::BoxMesh{size, cells, true, {}}, {1, 2, true}, {plane("base", 1, 0, 1, 0)}),
        flat(MPI_COMM_SELF, fem::BoxMesh{size, cells, true, {}}, {1, 2, true, Kinematics::plane_strain, 3},
             {plane("base", 1, 0, 1, 0)});
    CHECK(fem::crossing_steps(solid, o) == Approx(20 * std::sqrt(1.5) / 0.8).epsilon(1e-9));
    CHECK(fem::crossing_steps(flat, o) == Approx(20 * std::sqrt(1.5) / 0.8).epsilon(1e-9));
  }
}

TEST_CASE("the load eases into its bends and out of them, meets each exactly, and rests for two crossings at its end") {
  const double by = 1e-4;
  fem::Problem problem = column(by, 60, {{{0, 0}, {0.5, 1}, {1, 0.5}}});
  fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
  ExplicitStaticsOptions o = free_of_limits();
  o.crossings = 300;
  std::vector<double> at{0};  // the load factor while the top goes down, by where it is
  std::uint64_t resting = 0;
  double most = 0, last = 0;
  o.stop = [&] {
    const double now = moved(problem) / by;
    if (now > most) at.push_back(0.5 * now);
    resting = now == last ? resting + 1 : 0;
    most = std::max(most, now), last = now;
    return false;
  };
  o.output_interval = 10;
  REQUIRE(fem::solve_explicit_statics(problem, m, o, go_on).finished);
  CHECK(most == Approx(1).epsilon(1e-12));
  CHECK(last == Approx(0.5).epsilon(1e-12));
  const double crossing = fem::crossing_steps(problem, o), cap = 1 / (o.crossings * crossing);
  CHECK(std::abs(static_cast<double>(resting) + 1 - std::floor(2 * crossing)) <= 1);  // a row is no call of stop
  std::size_t eased = 0, whole = 0;
  for (std::size_t k = 1; k + 1 < at.size(); ++k) {
    const double from = at[k], step = at[k + 1] - from, left = 0.5 - from;
    if (from < 0.3 || left < 2 * cap) continue;
    const double part =
        std::min(1.0, std::sqrt(2 * left / (cap * 2 * crossing)));  // a constant force over two crossings
    if (part > 0.06) CHECK(step == Approx(part * cap).epsilon(1e-6));
    part < 1 ? ++eased : ++whole;
  }
  CHECK(eased > 5);
  CHECK(whole > 500);
}

TEST_CASE("the rate falls to where the material is at its inertial number, and to nothing else") {
  const double by = 1e-3;
  fem::Problem problem = column(by);
  fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
  double strained = 0;  // of the last step, mean over the points
  m.respond = [&, plain = m.respond](const fem::Points& points) {
    strained = 0;
    const std::size_t n = points.stress.size() / 6;
    for (std::size_t i = 0; i < n; ++i)
      strained += std::abs(points.deformation[9 * i + 4] - 1) / static_cast<double>(n);
    return plain(points);
  };
  m.inertial_number = [&] { return strained; };
  ExplicitStaticsOptions o = free_of_limits();
  o.crossings = 200;
  const double cap = 1 / (o.crossings * fem::crossing_steps(problem, o));
  o.inertial_number = by * cap / 3;  // met at a third of the fastest
  double sum = 0, count = 0;
  bool ruled = true;
  REQUIRE(fem::solve_explicit_statics(problem, m, o, [&](const ExplicitStaticsReport& r) {
            if (r.load_factor > 0.5 && r.load_factor < 0.9)
              sum += r.rate, ++count, ruled = ruled && r.governor == fem::Governor::inertial_number;
            return true;
          }).finished);
  REQUIRE(count > 10);
  CHECK(sum / count == Approx(cap / 3).epsilon(0.05));
  CHECK(ruled);
}

TEST_CASE("what starts the motion does not rule the rate: kinetic energy counts from a hundredth of the load on") {
  fem::Problem problem = column(1e-3);
  fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
  ExplicitStaticsOptions o = free_of_limits();
  o.kinetic = 1e-9, o.output_interval = 1e-4, o.crossings = 500;
  const double cap = 1 / (o.crossings * fem::crossing_steps(problem, o));
  double first = 0, later = 0;
  fem::solve_explicit_statics(problem, m, o, [&](const ExplicitStaticsReport& r) {
    if (r.load_factor < 0.009) first = std::max(first, r.rate);
    if (r.load_factor > 0.012 && later == 0) later = r.rate;
    return r.load_factor < 0.013;
  });
  CHECK(first > 2 * cap / 30);  // from a thirtieth of the cap it has grown
  CHECK(later < first);
}

TEST_CASE(
    "the unbalanced force that is told is the mean of the steps between two estimates; the largest, of all these") {
  fem::Problem problem = column(1e-3, 2);
  fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
  ExplicitStaticsOptions o = free_of_limits();
  o.crossings = 20, o.estimate_every = 10, o.output_interval = 0.05, o.damping = 0.05;
  // Nodes between two elements are free along the column; base and top, and what the sides hold, are driven.
  std::vector<double> each;  // after each step
  const auto look = [&] {
    const auto& p = problem.impl();
    const auto in = p.internal->array();
    double off = 0, applied = 0;
    for (std::size_t n = 0; n < p.node_at.size(); ++n) {
      const bool middle = std::abs(p.node_at[n][1] - 0.5) < 1e-9;
      if (middle) off = std::max(off, std::abs(in[2 * n + 1]));
      applied += middle ? std::abs(in[2 * n]) : std::hypot(in[2 * n], in[2 * n + 1]);
    }
    each.push_back(off / (applied / static_cast<double>(p.node_at.size())));
    return false;
  };
  o.stop = look;
  std::size_t rows = 0, waves = 0;
  REQUIRE(fem::solve_explicit_statics(problem, m, o, [&](const ExplicitStaticsReport& r) {
            look();
            if (r.steps < 40) return true;
            REQUIRE(r.steps == each.size());
            const auto last = each.begin() + static_cast<std::ptrdiff_t>(r.steps / 10 * 10 - 1), first = last - 10;
            CHECK(r.largest_unbalanced == Approx(*std::max_element(first, last)).epsilon(1e-9));
            CHECK(r.unbalanced == Approx(std::accumulate(first, last, 0.0) / 10).epsilon(1e-9));
            ++rows;
            if (*(last - 1) < 0.9 * r.largest_unbalanced) ++waves;
            return true;
          }).finished);
  CHECK(rows > 5);
  CHECK(waves > 0);
}

TEST_CASE("a softer start waits for its weight to be borne before the load begins; a borne one does not wait") {
  for (const bool borne : {false, true}) {
    fem::Problem problem = column(1e-3, 8);
    problem.set_gravity({0, -10, 0}, std::vector<double>(problem.owned_points(), 2000));
    fem::InitialStress initial;
    for (std::size_t i = 0; borne && i < problem.owned_points(); ++i)
      initial.push_back({0, -2e4 * (1 - problem.point_position(i)[1]), 0, 0, 0, 0});
    fem::Material m = fem::elastic_material(problem.owned_points(), E, nu, initial);
    ExplicitStaticsOptions o = free_of_limits();
    o.balance = 0.02;
    bool moves = false;
    std::uint64_t before = 0;  // steps until the top goes
    o.stop = [&] {
      double top = 0;
      for (const auto& c : problem.impl().prescribed)
        top = std::max(top, std::abs(problem.impl().u->array()[static_cast<std::size_t>(c.dof)]));
      moves = moves || top > 0;
      before += !moves;
      return moves;
    };
    const auto result = fem::solve_explicit_statics(problem, m, o, go_on);
    REQUIRE(result.stopped);
    CHECK((result.last.settling > 10) == !borne);
    CHECK((before > 10) == !borne);
  }
}

TEST_CASE("the rate that the nodes' drift goes by is meant over five crossings of the mesh, as the drift is") {
  fem::Problem problem = column(1e-3);
  fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
  ExplicitStaticsOptions o = free_of_limits();
  o.output_interval = 1e-7, o.crossings = 500;
  const double memory = 5 * fem::crossing_steps(problem, o);
  int early = 0;
  fem::solve_explicit_statics(problem, m, o, [&](const ExplicitStaticsReport& r) {
    // Each step's rate counts 1 / memory, less by so much with each step since; together they are the load factor.
    CHECK(r.mean_rate <= r.load_factor / memory * (1 + 1e-9));
    CHECK(r.mean_rate >= r.load_factor / memory * std::pow(1 - 1 / memory, static_cast<double>(r.steps)));
    early += static_cast<double>(r.steps) < 0.5 * memory;
    return r.load_factor < 1e-4;
  });
  CHECK(early > 0);
}

TEST_CASE("an element that carries next to nothing has a thousandth of the largest density; the others their own") {
  fem::Problem problem = column(1e-3);
  fem::Problem::Impl& p = problem.impl();
  const std::size_t points = problem.owned_points(), each = points / static_cast<std::size_t>(p.cells);
  std::vector<std::size_t> group(points, 2);  // of the first element, the second, all others
  for (std::size_t i = 0; i < 2 * each; ++i) group[i] = i / each;
  fem::Material m =
      fem::composite_material({fem::elastic_material(each, 1e-5 * E, nu), fem::elastic_material(each, 0.5 * E, nu),
                               fem::elastic_material(points - 2 * each, E, nu)},
                              group);
  ExplicitStaticsOptions o = free_of_limits();
  o.output_interval = 1e-3;
  fem::solve_explicit_statics(problem, m, o, [](const ExplicitStaticsReport&) { return false; });
  const std::vector<double>& density = p.of_cells.at("scaled density");
  REQUIRE(density.size() == 4);
  CHECK(density[0] == Approx(1e-3 * density[2]).epsilon(1e-3));
  CHECK(density[1] == Approx(0.5 * density[2]).epsilon(1e-3));
  CHECK(density[3] == Approx(density[2]).epsilon(1e-3));
}

TEST_CASE("masses that are scaled while nodes move put in half of what is gained times the speeds' squares") {
  // Pressed to two fifths of its volume a neo-Hookean column is some ten times as stiff.
  fem::Problem problem = column(0.6);
  fem::Material m = fem::test::hyperelastic(problem.owned_points(), 4e7, 4e7);
  ExplicitStaticsOptions o = free_of_limits();
  o.output_interval = 10;
  fem::Problem::Impl& p = problem.impl();
  std::vector<double> before, speed;
  double put_in = 0;
  o.stop = [&] {
    const auto& density = p.of_cells.at("scaled density");
    const auto& v = p.at_nodes.at("velocity");
    for (std::int32_t c = 0; c < p.cells && !before.empty(); ++c) {
      const double gained = density[static_cast<std::size_t>(c)] - before[static_cast<std::size_t>(c)];
      const Eigen::VectorXd share = gained * fem::cell_mass(p, c, [](std::size_t) { return 1.0; });
      for (int a = 0; a < p.nodes; ++a)
        for (std::size_t k = 0; k < p.width(); ++k) {
          const double u = v[p.width() * static_cast<std::size_t>(p.cell_nodes(c)[static_cast<std::size_t>(a)]) + k];
          put_in += 0.5 * share[a] * u * u;
        }
    }
    before = density;
    return false;
  };
  const auto result = fem::solve_explicit_statics(problem, m, o, go_on);
  REQUIRE(result.finished);
  CHECK(put_in > 0);
  CHECK(result.last.energy.scaled == Approx(put_in).epsilon(1e-6));
  fem::MacroEnergy e;
  e.external = 10, e.kinetic = 1, e.internal = 6, e.viscous = 0.5, e.damped = 4, e.scaled = 2;
  CHECK(e.error() == Approx((10 - 1 - 6 - 0.5 - 4 + 2) / 10));
}

TEST_CASE("damping ends a motion at most, and a node that is driven from the first step has its energy at once") {
  fem::BoundaryCondition push;
  push.name = "push", push.where = [](const Point& x) { return x[2] > 1 - 1e-9; }, push.traction = Point{0, 0, 1e5};
  fem::Problem loaded(MPI_COMM_SELF, fem::BoxMesh{{1, 1, 1}, {1, 1, 1}, true, {}}, {1, 2, true}, {push});
  fem::Material none = fem::elastic_material(loaded.owned_points(), E, nu);
  fem::CentralDifferences run(loaded.impl(), none);
  run.set_mass([&](std::int32_t c) { return fem::cell_mass(loaded.impl(), c, [](std::size_t) { return 800.0; }); });
  REQUIRE(run.respond(0, true, 0));
  for (std::size_t i = 0; i < run.velocity.size(); i += 3) run.velocity[i] = 1e-9;
  loaded.impl().assemble_external(1);
  fem::MacroEnergy total;
  run.step({1e-3, 1e-3, 1, 1, 0.8, false}, total);
  for (std::size_t i = 0; i < run.velocity.size(); i += 3) {
    CHECK(run.velocity[i] >= -1e-12);
    CHECK(run.velocity[i] <= 1e-9);
  }
  fem::Problem driven = column(0.1);
  fem::Material m = fem::elastic_material(driven.owned_points(), E, nu);
  fem::CentralDifferences first(driven.impl(), m);
  first.set_mass([&](std::int32_t c) { return fem::cell_mass(driven.impl(), c, [](std::size_t) { return 800.0; }); });
  REQUIRE(first.respond(0, true, 0));
  driven.impl().assemble_external(0);
  fem::MacroEnergy energy;
  first.step({1e-3, 0, 0, 1e-3, 0, true}, energy);
  const double speed = 0.1 * 1e-3 / 1e-3, mass = 800 * 0.25 / 2;  // of the two nodes at the top, half an element's
  CHECK(energy.kinetic == Approx(0.5 * mass * speed * speed).epsilon(1e-9));
  CHECK(energy.external == Approx(energy.kinetic).epsilon(1e-9));
}

}  // namespace grus
