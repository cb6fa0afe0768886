// SPDX-License-Identifier: LGPL-3.0-or-later
// A problem on several ranks: which nodes are loaded, what a snapshot holds, what means are of all.
#include <map>

#include "fem/explicit_statics.hpp"
#include "fem/hilbert_cut.hpp"
#include "fem/problem_impl.hpp"
#include "fem/statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/helpers.hpp"

namespace grus {  // DOLFINx has a namespace fem, too
namespace {

using fem::Kinematics;
using fem::Point;
using fem::test::plane;

constexpr double E = 1e8, nu = 0.25;

fem::BoundaryCondition pressed(std::string name, std::size_t axis, double place, double by) {
  fem::BoundaryCondition b;
  b.name = std::move(name), b.pressure = by, b.history.points = {{0, 1}};
  b.where = [=](const Point& x) { return std::abs(x[axis] - place) < 1e-9; };
  return b;
}

double applied(fem::Problem& problem, double time) {
  std::vector<std::uint8_t> marks;
  problem.impl().mark_applied(time, marks);
  double sum = 0;
  for (const auto m : marks) sum += m;
  return fem::sum_over_ranks(problem.comm(), sum);
}

/// 5 x 5 x 5 nodes: 4 elements a side of order 1, 2 of order 2; graded or even.
fem::Problem block(bool graded, int order, std::vector<fem::BoundaryCondition> loads) {
  fem::BoxMesh mesh{{1, 1, 1}, {4 / order, 4 / order, 4 / order}, true, {}};
  if (graded)
    mesh.map = [](const Point& x) {
      return Point{x[0] * (0.3 + 0.7 * x[0]), x[1] * (0.4 + 0.6 * x[1]), x[2] * (0.5 + 0.5 * x[2])};
    };
  for (const std::size_t k : {0u, 1u, 2u}) loads.push_back(plane("low " + std::to_string(k), k, 0, k, 0));
  return fem::Problem(MPI_COMM_WORLD, mesh, {order, order == 1 ? 2 : 4, true}, std::move(loads));
}

}  // namespace

TEST_CASE("forces are applied at nodes of loaded facets and prescribed ones, each once: not at those behind a facet") {
  for (const bool graded : {false, true})
    for (const int order : {1, 2}) {
      // Rollers on three faces, pressure on the other three: all nodes but the 3 x 3 x 3 inside.
      fem::Problem problem =
          block(graded, order, {pressed("x1", 0, 1, 1e5), pressed("y1", 1, 1, 1e5), pressed("z1", 2, 1, 1e5)});
      CHECK(applied(problem, 0) == 98);
      // Unstressed, all that the pressure does is out of balance, at all nodes but the corner where nothing is free:
      // S / 124 over S / 98, whatever S.
      fem::Material m = fem::elastic_material(problem.owned_points(), E, nu);
      fem::ExplicitStaticsOptions o;
      o.estimate_every = 1, o.stop = [] { return true; };
      const auto result = fem::solve_explicit_statics(problem, m, o, [](const auto&) { return true; });
      REQUIRE(result.stopped);
      CHECK(result.last.unbalanced == Approx(98.0 / 124).epsilon(1e-9));
    }
  // A load counts while it acts, and weight is applied everywhere.
  fem::BoundaryCondition later = pressed("y1", 1, 1, 1e5);
  later.history.points = {{0, 0}, {0.5, 0}, {1, 1}};
  fem::Problem problem = block(true, 1, {pressed("x1", 0, 1, 1e5), later});
  CHECK(applied(problem, 0) == 125 - 3 * 4 * 4);
  CHECK(applied(problem, 1) == 125 - 3 * 3 * 4);
  problem.set_gravity({0, 0, -10}, std::vector<double>(problem.owned_points(), 2000));
  CHECK(applied(problem, 0) == 125);
}

TEST_CASE("every cell of a snapshot tells the same of a node that it shares, whichever rank it lives on") {
  const auto make = [](MPI_Comm comm) {
    auto base = plane("base", 1, 0, 0, 0), top = plane("top", 1, 1, 1, -0.05);
    base.displacement[1] = 0, top.displacement[0] = 0.02;
    return fem::Problem(comm, fem::BoxMesh{{1, 1, 1}, {3, 5, 1}, true, {}}, {1, 2, true, Kinematics::plane_strain, 1},
                        {base, top});
  };
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  for (const bool by_newton : {false, true}) {
    fem::Problem spread = make(MPI_COMM_WORLD), whole = make(MPI_COMM_SELF);
    fem::Material m = fem::elastic_material(spread.owned_points(), E, nu);
    if (by_newton) {
      fem::StaticsOptions o;
      o.increments = 3;
      REQUIRE(fem::solve_statics(spread, m, o, [](const auto&) { return true; }).converged);
    } else {
      fem::ExplicitStaticsOptions o;
      std::uint64_t steps = 0;
      o.stop = [&] { return ++steps == 50; };
      o.output_interval = 1;
      REQUIRE(fem::solve_explicit_statics(spread, m, o, [](const auto&) { return true; }).stopped);
    }
    fem::Snapshot kept = spread.snapshot();
    // On one rank a node is one place: what its cells say of it, the last one wins.
    auto size = static_cast<std::uint64_t>(kept.values.size());
    MPI_Bcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    kept.values.resize(size);
    MPI_Bcast(kept.values.data(), static_cast<int>(size), MPI_DOUBLE, 0, MPI_COMM_WORLD);
    whole.restore(kept);
    CHECK((whole.snapshot().values == kept.values));
  }
}

TEST_CASE("the mean of ranks that hold different numbers of points is that of all points") {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const double mean = fem::mean_over_ranks(MPI_COMM_WORLD, rank == 0 ? 1.0 : 4.0, rank == 0 ? 1.0 : 2.0);
  const double others = ranks - 1;
  CHECK(mean == Approx((1 + 8 * others) / (1 + 2 * others)));
}

TEST_CASE("Hilbert's curve goes through every cell of a grid, from neighbour to neighbour") {
  for (const int dimensions : {2, 3})
    for (const int bits : {1, 2, 4}) {
      const std::uint32_t side = 1u << bits, high = dimensions == 3 ? side : 1;
      std::map<std::uint64_t, std::array<std::uint32_t, 3>> along;
      for (std::uint32_t x = 0; x < side; ++x)
        for (std::uint32_t y = 0; y < side; ++y)
          for (std::uint32_t z = 0; z < high; ++z) along[fem::hilbert_place({x, y, z}, dimensions, bits)] = {x, y, z};
      REQUIRE(along.size() == std::size_t{side} * side * high);
      CHECK(along.rbegin()->first == along.size() - 1);
      for (auto next = std::next(along.begin()); next != along.end(); ++next) {
        std::uint32_t way = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::uint32_t a = std::prev(next)->second[k], b = next->second[k];
          way += a > b ? a - b : b - a;
        }
        CHECK(way == 1);
      }
    }
}

TEST_CASE("a mesh is cut into parts of equal cost that lie together") {
  std::vector<Point> middles;
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; ++z) middles.push_back({x + 0.5, y + 0.5, z + 0.5});
  // Of equal costs eight parts are the octants of a cube, sixty-four its blocks of eight.
  for (const int parts : {8, 64}) {
    const auto part = fem::hilbert_cut(middles, std::vector<double>(512, 2.5), parts);
    std::map<std::int32_t, std::vector<Point>> in;
    for (std::size_t k = 0; k < part.size(); ++k) in[part[k]].push_back(middles[k]);
    REQUIRE(in.size() == static_cast<std::size_t>(parts));
    CHECK((in.begin()->first == 0 && in.rbegin()->first == parts - 1));
    for (const auto& [number, points] : in) {
      CHECK(points.size() == 512 / static_cast<std::size_t>(parts));
      for (std::size_t k = 0; k < 3; ++k) {
        double low = 8, high = 0;
        for (const Point& x : points) low = std::min(low, x[k]), high = std::max(high, x[k]);
        CHECK(high - low == (parts == 8 ? 3 : 1));
      }
    }
  }
  // One half is eight times as dear: no part is off by more than a dear element.
  std::vector<double> costs;
  for (const Point& x : middles) costs.push_back(x[0] < 4 ? 8 : 1);
  std::vector<double> sum(7, 0.0);
  const auto part = fem::hilbert_cut(middles, costs, 7);
  for (std::size_t k = 0; k < part.size(); ++k) sum[static_cast<std::size_t>(part[k])] += costs[k];
  for (const double of : sum) CHECK(std::abs(of - 256 * 9 / 7.0) <= 8);
  // Wherever the mesh lies, and in whatever units, it is cut alike.
  for (const auto& [shift, size] : {std::pair{-1000.0, 1.0}, {1000.0, 1.0}, {0.0, 1e-3}}) {
    std::vector<Point> moved = middles;
    for (Point& x : moved)
      for (double& v : x) v = size * (v + shift);
    CHECK(fem::hilbert_cut(moved, costs, 7) == part);
  }
  // Of costs only their shares count: seconds of a step, or of all of a run.
  for (const double unit : {1e-7, 1e7}) {
    std::vector<double> in = costs;
    for (double& c : in) c *= unit;
    CHECK(fem::hilbert_cut(middles, in, 7) == part);
  }
  // More parts than elements: each element has one of its own.
  const auto few = fem::hilbert_cut({{0, 0, 0}, {1, 0, 0}}, {1, 1}, 5);
  CHECK(few[0] != few[1]);
}

TEST_CASE("an element goes to the rank that it was told, of boxes and of files") {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  fem::BoxMesh box{{1, 1, 1}, {3, 2, 2}, true, {}};
  fem::MshMesh file;
  file.kind = fem::CellKind::quadrilateral;
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 13; ++x) file.nodes.push_back({1.0 * x, 1.0 * y, 0});
  for (int x = 0; x < 12; ++x)
    for (const int n : {x, x + 1, x + 14, x + 13}) file.cells.push_back(n);
  for (int k = 0; k < 12; ++k) box.owner.push_back((k * k + 1) % ranks);
  file.owner = box.owner;
  fem::Problem of_box(MPI_COMM_WORLD, box, {}, {plane("low", 2, 0, 2, 0)});
  fem::Discretisation flat;
  flat.kinematics = Kinematics::plane_strain;
  fem::Problem of_file(MPI_COMM_WORLD, file, flat, {plane("low", 1, 0, 1, 0)});
  for (const fem::Problem* problem : {&of_box, &of_file}) {
    const auto own = problem->own_elements();
    for (const auto element : own) CHECK(box.owner[static_cast<std::size_t>(element)] == rank);
    CHECK(own.size() == static_cast<std::size_t>(std::count(box.owner.begin(), box.owner.end(), rank)));
  }
}

}  // namespace grus
