// SPDX-License-Identifier: LGPL-3.0-or-later
// Sums that are the same to the bit in any order and on any ranks: against closed forms; and what explicit runs make of
// them.
#include "fem/exact_sum.hpp"

#include <cstring>
#include <random>

#include "fem/dynamics.hpp"
#include "fem/explicit_statics.hpp"
#include "fem/problem_impl.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/helpers.hpp"

namespace grus {  // DOLFINx has a namespace fem, too
namespace {

using fem::ElementKind;
using fem::ExactSum;
using fem::Kinematics;
using fem::Point;
using fem::test::plane;

double sum_of(std::initializer_list<double> numbers) {
  ExactSum sum;
  for (const double x : numbers) sum += x;
  return sum.value();
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

TEST_CASE("an exact sum is the double nearest to the sum, whatever cancels") {
  CHECK(sum_of({}) == 0);
  CHECK(sum_of({1e16, 1, -1e16}) == 1);
  CHECK(sum_of({0.1, 0.2, -0.3}) == 0x1p-55);  // of these doubles; one after the other 2^-54
  CHECK(sum_of({1e30, 1e-30, -1e30}) == 1e-30);
  CHECK(sum_of({1, 0x1p-53}) == 1);                      // halfway: to even
  CHECK(sum_of({1, 0x1p-53, 0x1p-200}) == 1 + 0x1p-52);  // just above halfway
  CHECK(sum_of({1, 0x1p-52, 0x1p-53}) == 1 + 0x1p-51);   // halfway, the other even one
  CHECK(sum_of({-1, -0x1p-53, -0x1p-200}) == -1 - 0x1p-52);
  CHECK(sum_of({0x1p64, -1}) == 0x1p64);  // borrows over two digits
  CHECK(sum_of({0x1p64, -0x1.8p11}) == 0x1p64 - 0x1p12);
  for (int e = -204; e < 128; ++e)
    for (const double m : {1.0, 0x1.fffffffffffffp0, -0x1.0000000000001p0})
      CHECK(sum_of({std::ldexp(m, e)}) == std::ldexp(m, e));
}

TEST_CASE("an exact sum holds what it says, and tells of what it cannot hold") {
  CHECK(sum_of({0x1p-256}) == 0x1p-256);
  CHECK(sum_of({0x1.8p-256}) == 0x1p-256);  // cut off below
  CHECK(sum_of({0x1p-257, 5e-324, 0.0, -0.0}) == 0);
  const double largest = 0x1.fffffffffffffp127;
  CHECK(sum_of({largest, 1, -largest}) == 1);
  for (const double bad : {0x1p128, -0x1p128, double(INFINITY), -double(INFINITY), double(NAN)})
    CHECK(std::isnan(sum_of({1, bad})));
  CHECK(std::isnan(sum_of({double(INFINITY), -double(INFINITY)})));
  for (const double sign : {1.0, -1.0}) {  // 2^62 numbers of the largest size, by doubling
    ExactSum sum;
    sum += sign * largest;
    for (int k = 0; k < 62; ++k) sum += ExactSum(sum);
    CHECK(sum.value() == sign * std::ldexp(largest, 62));
    sum += -sign * largest;
    CHECK(sum.value() == sign * std::ldexp(largest, 62));
  }
  // Each of the three digits that a number adds to, either way, from nearly full on: no digit runs over.
  constexpr std::int64_t full = INT64_MAX - 0xffffffff;  // 2^63 - 2^32
  const double number = 0x1.fffffffffffffp83;            // digits 8, 9 and 10; to the last one it adds 2^20
  for (const double sign : {1.0, -1.0})
    for (std::size_t k = 8; k < 11; ++k) {
      ExactSum::Words words{};
      words[k] = sign > 0 ? full : -full;
      ExactSum sum = ExactSum::of(words);
      for (int n = 0; n < 8192; ++n) sum += sign * number;
      const double begin = std::ldexp(static_cast<double>(full), 32 * (static_cast<int>(k) - 8));
      CHECK(sum.value() == sum_of({sign * begin, sign * std::ldexp(number, 13)}));
    }
}

TEST_CASE("the same numbers in any order and dealt to any number of parts have one sum, to the bit") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> size(-12, 12), sign(-1, 1);
  std::vector<double> numbers(100000);
  for (double& x : numbers) x = sign(random) * std::pow(10, size(random));
  // Independent: each number is an integer of 2^-96, and 128 bits hold them all.
  __extension__ using Wide = __int128;
  Wide wide = 0;
  for (double& x : numbers) x = std::ldexp(std::nearbyint(std::ldexp(x, 60)), -60), wide += Wide(std::ldexp(x, 60));
  const double expected = std::ldexp(static_cast<double>(wide), -60);
  double plain_first = 0;
  bool plain_parts = false;
  for (int order = 0; order < 10; ++order) {
    std::shuffle(numbers.begin(), numbers.end(), random);
    double plain = 0;
    for (const double x : numbers) plain += x;
    if (order == 0) plain_first = plain;
    plain_parts = plain_parts || plain != plain_first;
    for (const std::size_t parts : {1u, 2u, 3u, 7u, 64u}) {
      std::vector<ExactSum> part(parts);
      for (std::size_t i = 0; i < numbers.size(); ++i) part[(i * i) % parts] += numbers[i];
      ExactSum sum;
      for (const ExactSum& p : part) sum += p;
      CHECK(same_bits(sum.value(), expected));
    }
  }
  CHECK(plain_parts);  // what this is for
}

TEST_CASE("sums over ranks are exact, and so is what is no number") {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const auto sums = fem::sums_over_ranks<3>(MPI_COMM_WORLD, true, [&](auto& s) {
    for (int k = 0; k < 100; ++k)
      if (k % ranks == rank) s[0] += (k % 2 == 0 ? 1e15 : -1e15) + 0.125 * k, s[1] += std::ldexp(-1.0, k);
    if (rank == ranks - 1) s[2] += NAN;
  });
  CHECK(sums[0] == 0.125 * 4950);
  CHECK(sums[1] == -0x1p100);  // nearest to 1 - 2^100
  CHECK(std::isnan(sums[2]));
  CHECK(fem::sums_over_ranks<1>(MPI_COMM_WORLD, false, [](auto& s) { s[0] += 2; })[0] == 2 * ranks);
}

namespace {

struct Case {
  const char* name;
  bool brick, flat;
  int order;
  ElementKind element;
};

fem::Problem block(MPI_Comm comm, const Case& c, bool exact) {
  fem::BoxMesh mesh{{1, 1, 1}, {3, 4, c.flat ? 1 : 2}, c.brick, {}};
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  const int elements = (c.flat ? 12 : 24) * (c.brick ? 1 : c.flat ? 2 : 6);
  for (int k = 0; k < elements && ranks > 1; ++k) mesh.owner.push_back(k * k % 7 % ranks);  // any, also torn apart
  mesh.map = [&](const Point& x) { return Point{x[0] * (0.7 + 0.3 * x[1]), x[1] * (0.4 + 0.6 * x[1]), x[2]}; };
  auto base = plane("base", 1, 0, 0, 0), top = plane("top", 1, 1, 1, -0.03);
  base.displacement[1] = 0, top.displacement[0] = 0.01;
  fem::BoundaryCondition side;
  side.name = "side", side.pressure = 3e5, side.history.points = {{0, 1}};
  side.where = [](const Point& x) { return std::abs(x[0]) < 1e-9; };
  fem::Discretisation d{c.order,  c.order == 1 ? 2 : 4, true, c.flat ? Kinematics::plane_strain : Kinematics::solid, 1,
                        c.element};
  d.exact_sums = exact;
  return fem::Problem(comm, mesh, d, {base, top, side});
}

/// All that a run tells, row by row, and its last state by element: on rank 0.
std::vector<double> told(fem::Problem& problem) {
  problem.set_gravity({0, -10, 0}, std::vector<double>(problem.owned_points(), 2000.7));
  fem::Material m = fem::j2_material(problem.owned_points(), 1e8, 0.25, 1e6, 1e6);
  fem::ExplicitStaticsOptions o;
  o.balance = 0.5, o.kinetic = 0.5, o.crossings = 3, o.output_interval = 0.1, o.max_energy_error = 10;
  std::uint64_t steps = 0;
  o.stop = [&] { return ++steps == 150; };
  std::vector<double> all;
  const auto row = [&](const fem::ExplicitStaticsReport& r) {
    const auto& e = r.energy;
    all.insert(all.end(), {r.load_factor, r.rate, r.mean_rate, r.unbalanced, r.largest_unbalanced, e.kinetic,
                           e.internal, e.external, e.work, e.damped, e.scaled});
    for (std::size_t b = 0; b < 3; ++b) {
      for (const double v : problem.reaction(b)) all.push_back(v);
      for (const double v : problem.mean_displacement(b)) all.push_back(v);
    }
    for (const double v : problem.mean_stress()) all.push_back(v);
    for (const double v : problem.mean_strain()) all.push_back(v);
    for (const double v : problem.volumes({})) all.push_back(v);
    return true;
  };
  const auto result = fem::solve_explicit_statics(problem, m, o, row);
  CHECK((result.stopped || result.finished));
  row(result.last);
  all.push_back(fem::crossing_steps(problem, o));
  const std::vector<double> state = problem.snapshot().values;
  all.insert(all.end(), state.begin(), state.end());
  return all;
}

/// The same of explicit dynamics: a blow, softened by bulk viscosity, stopped and gone on with.
std::vector<double> told_of_blow(fem::Problem& problem) {
  const std::vector<double> density(problem.owned_points(), 2000.7);
  fem::Material m = fem::elastic_material(problem.owned_points(), 1e8, 0.25);
  fem::DynamicsOptions o;
  o.duration = 0.02, o.linear_viscosity = 0.1, o.quadratic_viscosity = 1.2, o.output_interval = 1e-3;
  o.max_energy_error = 10;
  std::vector<double> all;
  const auto row = [&](const fem::DynamicsReport& r) {
    const auto& e = r.energy;
    all.insert(all.end(), {r.time, r.dt, r.dissipated, e.kinetic, e.internal, e.external, e.work, e.viscous});
    for (const double v : problem.reaction(0)) all.push_back(v);
    return true;
  };
  std::uint64_t steps = 0;
  o.stop = [&] { return ++steps == 7; };
  fem::DynamicsResult result = fem::solve_dynamics(problem, m, density, o, row);
  CHECK(result.stopped);
  result = fem::solve_dynamics(problem, m, density, o, row, result.last);
  CHECK(result.finished);
  CHECK(result.last.energy.viscous > 0);
  const std::vector<double> state = problem.snapshot().values;
  all.insert(all.begin(), state.begin(), state.end());
  row(result.last);  // what is told last: 11 numbers
  return all;
}

}  // namespace

TEST_CASE("explicit dynamics with exact sums tells the same bits on one rank and on all") {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const Case c{"hexahedra", true, false, 1, ElementKind::standard};
  fem::Problem spread = block(MPI_COMM_WORLD, c, true), whole = block(MPI_COMM_SELF, c, true),
               plain = block(MPI_COMM_SELF, c, false);
  const std::vector<double> a = told_of_blow(spread), b = told_of_blow(whole), other = told_of_blow(plain);
  if (rank == 0) CHECK((a.size() == b.size() && std::memcmp(a.data(), b.data(), 8 * a.size()) == 0));
  REQUIRE(b.size() == other.size());
  for (std::size_t k = b.size() - 11; k < b.size(); ++k) CHECK(b[k] == Approx(other[k]).epsilon(1e-9).margin(1e-6));
}

TEST_CASE("an explicit run with exact sums tells the same bits on one rank and on all; without them it does not") {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  for (const Case& c : {Case{"hexahedra", true, false, 1, ElementKind::standard},
                        {"mean dilatation", true, false, 1, ElementKind::fbar},
                        {"tetrahedra", false, false, 1, ElementKind::standard},
                        {"triangles of order 2", false, true, 2, ElementKind::standard},
                        {"serendipity", true, true, 2, ElementKind::serendipity}}) {
    INFO(c.name);
    bool same[2];
    std::vector<double> exact;
    for (const bool sums : {false, true}) {
      fem::Problem spread = block(MPI_COMM_WORLD, c, sums), whole = block(MPI_COMM_SELF, c, sums);
      const std::vector<double> a = told(spread), b = told(whole);
      // Only rank 0 has the state of all elements.
      same[sums] = rank != 0 || (a.size() == b.size() && std::memcmp(a.data(), b.data(), 8 * a.size()) == 0);
      if (!sums) exact = b;
      if (sums) {  // and it is the same run but for round-off
        REQUIRE(b.size() == exact.size());
        for (const std::size_t k : {0u, 3u, 5u, 6u, 7u, 9u, 12u, 15u}) CHECK(b[k] == Approx(exact[k]).epsilon(1e-9));
      }
    }
    CHECK(same[1]);
    if (rank == 0) CHECK(same[0] == (ranks == 1));
  }
}

TEST_CASE("nodes of a spread problem lie where those of a whole one lie, to the bit") {
  for (const Case& c : {Case{"", true, false, 1, ElementKind::standard},
                        {"", true, false, 2, ElementKind::serendipity},
                        {"", false, false, 2, ElementKind::standard}}) {
    fem::Problem spread = block(MPI_COMM_WORLD, c, true), whole = block(MPI_COMM_SELF, c, true);
    const std::vector<Point>&some = spread.impl().node_at, &all = whole.impl().node_at;
    std::size_t found = 0;
    for (const Point& x : some) found += std::find(all.begin(), all.end(), x) != all.end() ? 1u : 0u;
    CHECK(found == some.size());
  }
}

TEST_CASE("a nodal sum is off by 2^-50 of the largest contribution at most, and no number is told of everywhere") {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  fem::Problem problem = block(MPI_COMM_WORLD, {"", true, false, 1, ElementKind::standard}, true);
  fem::Problem::Impl& p = problem.impl();
  std::mt19937_64 random(static_cast<std::uint64_t>(rank));
  std::uniform_real_distribution<double> uniform(-1, 1);
  fem::Problem::Impl::Vector plain(p.space->dofmap()->index_map, 3), exact(p.space->dofmap()->index_map, 3);
  std::vector<fem::Contribution> parts;
  for (std::int32_t c = 0; c < p.cells; ++c)
    for (const auto node : p.cell_nodes(c))
      for (std::int32_t k = 0; k < 3; ++k) parts.push_back({3 * node + k, 1e9 * uniform(random)});
  plain.set(0.0);
  for (const auto& c : parts) plain.mutable_array()[static_cast<std::size_t>(c.at)] += c.value;
  plain.scatter_rev(std::plus<double>());
  const auto owned = exact.mutable_array().subspan(0, 3 * static_cast<std::size_t>(p.owned_nodes()));
  p.quanta->add_up(parts, owned);
  for (std::size_t i = 0; i < owned.size(); ++i)  // 8 contributions, and the round-off of the plain sum
    CHECK(std::abs(owned[i] - plain.array()[i]) <= 8 * 1e9 * (0x1p-50 + 0x1p-52));
  if (!parts.empty() && rank == 0) parts.front().value = NAN;
  p.quanta->add_up(parts, owned);
  for (const double v : owned) CHECK(std::isnan(v));
  for (auto& c : parts) c.value = 0;
  p.quanta->add_up(parts, owned);
  for (const double v : owned) CHECK(v == 0);
  for (const auto& [share, quanta] : {std::pair{0.25, 0.0}, {0.5, 0.0}, {0.75, 1.0}, {1.5, 2.0}, {-0.75, -1.0}}) {
    parts = {{0, 0.75}, {1, share * 0x1p-50}};  // to the nearest quantum, of two the even one
    p.quanta->add_up(parts, owned);
    if (!owned.empty()) CHECK(owned[1] == quanta * 0x1p-50);
  }
  for (const double small : {5e-324, 1e-299}) {  // there is no quantum of 50 bits below them
    for (auto& c : parts) c.value = small;
    p.quanta->add_up(parts, owned);
    for (const double v : owned) CHECK(v == 0);
  }
}

}  // namespace grus
