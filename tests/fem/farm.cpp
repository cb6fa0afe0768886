// SPDX-License-Identifier: LGPL-3.0-or-later
// RVEs on several ranks: dealt out, moved, and what happens when one of them fails.
#include "coupling/rve_farm.hpp"
#include "dem/base/error.hpp"
#include "tests/fem/sand.hpp"

using namespace grus;
using namespace grus::dem;
using fem::test::standard;

namespace {

/// Works with a farm of all ranks; the others serve.
template <class Work>
void on_rank_0(Work work) {
  int rank, ranks;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  dem::ResponseOptions with;
  with.quasi_static = standard().q;
  if (rank > 0) return coupling::serve(MPI_COMM_WORLD, standard().model, with, 1);
  coupling::RveFarm farm(MPI_COMM_WORLD, standard().model, with, 1);
  work(farm, ranks);
}

}  // namespace

TEST_CASE("RVEs are dealt to ranks by cost, and moving one changes nothing") {
  const std::vector<double> costs{5, 1, 1, 1, 4, 2, 2};
  const std::vector<int> to = coupling::balance(costs, 2);
  double load[2] = {0, 0};
  for (std::size_t i = 0; i < costs.size(); ++i) load[to[i]] += costs[i];
  CHECK(load[0] == 8);
  CHECK(load[1] == 8);
  on_rank_0([](coupling::RveFarm& farm, int ranks) {
    for (std::uint64_t slot = 0; slot < 6; ++slot) farm.put(slot, standard().state, 1);
    // Slots of one rank get long paths, the others' none: measured times are out of balance.
    Mat3 f = Mat3::Identity();
    f(2, 2) -= 1e-3;
    std::vector<dem::Task> tasks;
    for (std::uint64_t slot = 0; slot < 6; ++slot)
      tasks.push_back({slot, std::vector<Mat3>(slot % 2 == 0 ? 6 : 1, slot % 2 == 0 ? f : Mat3::Identity())});
    farm.advance(tasks);
    farm.commit({0, 1, 2, 3, 4, 5});
    std::vector<std::string> before, after;
    for (std::uint64_t slot = 0; slot < 6; ++slot) before.push_back(farm.fetch(slot));
    farm.rebalance();
    for (std::uint64_t slot = 0; slot < 6; ++slot) after.push_back(farm.fetch(slot));
    CHECK((before == after));
    CHECK((before[0] == before[2]));  // the same path gives the same bytes on any rank
    CHECK((farm.moved() > 0) == (ranks == 2));
  });
}

TEST_CASE("what fails on another rank fails here, in the same words, and the farm goes on") {
  on_rank_0([](coupling::RveFarm& farm, int ranks) {
    farm.put(0, standard().state, 1);  // here
    // Bytes that are no state: refused where they arrive.
    CHECK_THROWS_AS(farm.put_bytes(1, "no state at all", 1), InputError);
    farm.put(1, standard().state, 1);
    const std::string good = farm.fetch(1);
    // Rank 1 is asked to commit, and rank 0 fails before it listens: nothing to commit here.
    Mat3 f = Mat3::Identity();
    f(2, 2) -= 1e-4;
    const auto done = farm.advance({{1, {f}}});
    REQUIRE(done[0].response.stable);
    CHECK_THROWS_AS(farm.commit({1, 0}), std::logic_error);
    if (ranks > 1) CHECK(farm.fetch(1) != good);  // the answer that nobody took does not get in the way of the next
    // Committing twice fails where the RVE lives.
    if (ranks > 1) CHECK_THROWS_AS(farm.commit({1}), std::runtime_error);
    const auto again = farm.advance({{0, {f}}, {1, {f}}});
    CHECK(again[0].response.stable);
    CHECK(again[1].response.stable);
    // One more answer is left on its way as the farm is taken down: the other rank must hear that it may go.
    CHECK_THROWS_AS(farm.commit({1, 77}), std::out_of_range);
    farm.commit({0});
    CHECK_THROWS_AS(farm.commit({1, 0}), std::logic_error);
  });
}
