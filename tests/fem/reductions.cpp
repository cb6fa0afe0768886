// SPDX-License-Identifier: LGPL-3.0-or-later
// What a step of an explicit run with exact sums asks of all ranks: counted; and what any rank tells there, all hear.
#include "fem/dynamics.hpp"
#include "fem/explicit_statics.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/helpers.hpp"

namespace {
int asked = 0;
}

#undef MPI_Allreduce  // PETSc counts its calls, too

/// Stands before that of the library, which it calls.
extern "C" int MPI_Allreduce(const void* in, void* out, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  ++asked;
  return PMPI_Allreduce(in, out, count, type, op, comm);
}

namespace grus {  // DOLFINx has a namespace fem, too
namespace {

using fem::Point;
using fem::test::plane;

fem::Problem pressed(double by) {
  auto base = plane("base", 2, 0, 2, 0), top = plane("top", 2, 1, 2, by);
  base.displacement = {0.0, 0.0, 0.0};
  fem::BoundaryCondition side;
  side.name = "side", side.pressure = 3e5, side.history.points = {{0, 1}};
  side.where = [](const Point& x) { return std::abs(x[0]) < 1e-9; };
  fem::Discretisation d{1, 2, true};
  d.exact_sums = true;
  return fem::Problem(MPI_COMM_WORLD, fem::BoxMesh{{1, 1, 1}, {2, 2, 2}, true, {}}, d, {base, top, side});
}

/// Reductions of each step between two reports, over which neither masses nor the rate are found anew.
struct Counted {
  std::vector<int> steps, heard;
  int before = 0;

  fem::Wishes wishes() {
    int rank = 0, ranks = 1;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    return {[this, last = rank == ranks - 1] { return last && heard.size() == 30 ? 5 : 0; },
            [this](int any) { heard.push_back(any); }};
  }
  bool stop() {
    steps.push_back(asked - before), before = asked;
    return steps.size() == 60;
  }
  void check(int expected) const {
    REQUIRE(steps.size() == 60);
    for (std::size_t k = 40; k < steps.size(); ++k) CHECK(steps[k] == expected);
    for (std::size_t k = 0; k < heard.size(); ++k) CHECK(heard[k] == (k == 30 ? 5 : 0));
  }
};

}  // namespace

TEST_CASE("a quasi-static step with exact sums asks all ranks twice, and what one wishes all hear in that step") {
  fem::Problem problem = pressed(-0.01);
  fem::Material m = fem::elastic_material(problem.owned_points(), 1e8, 0.25);
  fem::ExplicitStaticsOptions o;
  o.balance = 0.5, o.kinetic = 0.5, o.estimate_every = 1000, o.output_interval = 1, o.max_energy_error = 10;
  Counted counted;
  o.stop = [&] { return counted.stop(); }, o.wishes = counted.wishes();
  CHECK(fem::solve_explicit_statics(problem, m, o, [](const auto&) { return true; }).last.load_factor > 0);
  counted.check(2);
}

TEST_CASE("a step of explicit dynamics with exact sums asks all ranks twice, and once more for bulk viscosity") {
  for (const double viscosity : {0.0, 0.1}) {
    fem::Problem problem = pressed(-0.01);
    fem::Material m = fem::elastic_material(problem.owned_points(), 1e8, 0.25);
    fem::DynamicsOptions o;
    o.duration = 1, o.linear_viscosity = viscosity, o.estimate_every = 1000, o.output_interval = 1;
    o.max_energy_error = 10;
    Counted counted;
    o.stop = [&] { return counted.stop(); }, o.wishes = counted.wishes();
    fem::solve_dynamics(problem, m, std::vector<double>(problem.owned_points(), 2000.0), o,
                        [](const auto&) { return true; });
    counted.check(viscosity > 0 ? 3 : 2);
  }
}

TEST_CASE("a point that fails on one rank, or an element there, ends the run on all") {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  fem::ExplicitStaticsOptions o;
  o.balance = 0.5, o.kinetic = 0.5, o.crossings = 1, o.max_energy_error = 1e9;
  const auto row = [](const auto&) { return true; };
  fem::Problem problem = pressed(-0.01);
  fem::Material m = fem::elastic_material(problem.owned_points(), 1e8, 0.25);
  int answers = 0;
  m.respond = [&, respond = m.respond](const fem::Points& p) {
    return respond(p) && (++answers < 10 || rank < ranks - 1);
  };
  m.reason = [&] { return std::string(rank == ranks - 1 ? "it fails here" : ""); };
  const auto failed = fem::solve_explicit_statics(problem, m, o, row);
  CHECK(failed.last.steps == 8);
  CHECK(failed.failure.ends_with(rank == ranks - 1 ? "it fails here" : "a Gauss point of another rank failed"));
  fem::Problem flattened = pressed(-1.5);
  fem::Material elastic = fem::elastic_material(flattened.owned_points(), 1e8, 0.25);
  const auto turned = fem::solve_explicit_statics(flattened, elastic, o, row);
  CHECK(turned.failure.ends_with("an element turned inside out"));
}

}  // namespace grus
