// SPDX-License-Identifier: LGPL-3.0-or-later
// RVEs on several ranks: dealt out, moved, and what happens when one of them fails.
#include <algorithm>
#include <ctime>

#include "coupling/rve_material.hpp"
#include "dem/base/error.hpp"
#include "tests/fem/sand.hpp"

namespace grus {  // headers of DOLFINx bring another `fem` into the global space

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

TEST_CASE("a slot that is dropped takes its cost along: the next one comes to where there is least to do by then") {
  on_rank_0([](coupling::RveFarm& farm, int) {
    farm.put(0, standard().state, 10);  // here
    farm.put(1, standard().state, 1);   // on the second rank, if there is one
    farm.drop(0);
    const auto before = farm.traffic();
    farm.put(2, standard().state, 1);  // here, where nothing is
    CHECK(farm.traffic() == before);
  });
}

TEST_CASE("what fails on another rank fails here, in the same words, and the farm goes on") {
  on_rank_0([](coupling::RveFarm& farm, int ranks) {
    farm.put(0, standard().state, 1);  // here
    // Bytes that are no state: refused where they arrive.
    CHECK_THROWS_AS(farm.put(1, "no state at all", 1), InputError);
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

TEST_CASE("slots are dealt and moved in no more than their number times its logarithm") {
  // Costs of 1 and 8 in halves of the slots, each half on one side of the ranks.
  constexpr int ranks = 64;
  const auto seconds = [](std::size_t slots) {
    std::vector<coupling::Lodger> lodgers;
    for (std::size_t i = 0; i < slots; ++i) {
      const int rank = static_cast<int>(i * ranks / slots);
      lodgers.push_back({i, rank, rank < ranks / 2 ? 8e-4 : 1e-4});
    }
    const std::clock_t before = std::clock();
    const auto moves = coupling::moves_to_balance(lodgers, ranks);
    const double took = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    std::vector<double> load(ranks, 0);
    for (const auto& m : moves) lodgers[m.slot].rank = m.to;
    for (const auto& l : lodgers) load[static_cast<std::size_t>(l.rank)] += l.cost;
    const double mean = 4.5e-4 * static_cast<double>(slots) / ranks;
    CHECK(*std::max_element(load.begin(), load.end()) <= 1.1 * mean + 1e-12);
    CHECK(moves.size() <= slots / 2);
    return took;
  };
  const double few = seconds(4096), many = seconds(262144);
  INFO(few << " s, " << many << " s of CPU for 64 times as many");
  CHECK(many < 5);  // looking at all slots for each move: minutes
  // What nothing helps stays: one RVE alone is dearer than all others together.
  CHECK(coupling::moves_to_balance({{0, 0, 10}, {1, 1, 1}}, 2).empty());
  CHECK(coupling::moves_to_balance({{0, 0, 1}, {1, 1, 1}}, 2).empty());
  const auto moves = coupling::moves_to_balance({{0, 0, 3}, {1, 0, 2}, {2, 0, 1}, {3, 1, 2}}, 2);
  REQUIRE(moves.size() == 1);
  CHECK((moves[0].slot == 0 || moves[0].slot == 1 || moves[0].slot == 2));
  coupling::Loads loads(3);
  loads.add(0, 1), loads.add(1, 2);
  CHECK(loads.idlest() == 2);
  loads.add(2, 3);
  CHECK(loads.idlest() == 0);
  CHECK(loads.busiest() == 2);
  CHECK(loads.mean() == 2);
}

TEST_CASE("a tangent crosses ranks where it is asked for: 288 bytes") {
  on_rank_0([](coupling::RveFarm& farm, int ranks) {
    for (std::uint64_t slot = 0; slot < 4; ++slot) farm.put(slot, standard().state, 1);
    std::uint64_t back[2];
    for (const bool asked : {false, true}) {
      std::vector<dem::Task> tasks;
      for (std::uint64_t slot = 0; slot < 4; ++slot)
        tasks.push_back({slot, {Mat3::Identity()}, 0, dem::Pace::steady, asked});
      const std::uint64_t before = farm.traffic()[1];
      const auto done = farm.advance(tasks);
      back[asked] = farm.traffic()[1] - before;
      for (const auto& d : done) {
        CHECK(d.response.stable);
        if (asked) CHECK(d.response.tangent(0, 0) > 0);
      }
    }
    CHECK(back[1] - back[0] == (ranks == 2 ? 2u * 36 * sizeof(double) : 0u));
  });
}

TEST_CASE("explicit runs move RVEs by what they have cost, and nothing else changes") {
  dem::ResponseOptions response;
  response.quasi_static = standard().q;
  coupling::RveOptions with;
  with.response = response, with.pace = dem::Pace::steady, with.exact_sharing = false;
  const auto run = [&](coupling::RveFarm& farm) {
    coupling::RveMaterial rves(farm, {standard().state}, {0, 0, 0, 0, 0, 0}, with);
    const fem::Material m = rves.material();
    std::vector<double> f(54, 0), stress(36), all;
    for (int step = 0; step < 210; ++step) {
      for (std::size_t i = 0; i < 6; ++i)  // every other point goes fast: those are all of one rank
        f[9 * i] = f[9 * i + 4] = 1, f[9 * i + 8] = 1 - (i % 2 == 0 ? 3e-5 : 0);
      REQUIRE(m.respond({f, stress, {}}));
      m.commit();
      all.insert(all.end(), stress.begin(), stress.end());
    }
    return all;
  };
  on_rank_0([&](coupling::RveFarm& farm, int ranks) {
    const auto spread = run(farm);
    coupling::RveFarm here(MPI_COMM_SELF, standard().model, response, 1);
    CHECK((spread == run(here)));
    if (ranks == 2) CHECK(farm.moved() > 0);
    if (ranks == 1) CHECK(farm.moved() == 0);
  });
}

}  // namespace grus
