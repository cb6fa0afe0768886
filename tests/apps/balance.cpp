// SPDX-License-Identifier: LGPL-3.0-or-later
// A cut in the midst of a run: when it pays, and what goes where.
#include "apps/bvp/balance.hpp"

#include <cstring>
#include <map>

#include "apps/bvp/shards.hpp"
#include "dem/base/error.hpp"
#include "tests/catch.hpp"

using namespace grus::app;

TEST_CASE("balance: the fullest rank over the mean") {
  CHECK(fullness({1, 8}) == 16.0 / 9);
  CHECK(fullness({3, 3, 3}) == 1);
  CHECK(fullness({0, 0}) == 1);
  Balance b;
  CHECK(b.imbalance() == 1);
  count(b, {10, 30}), count(b, {100, 60});
  CHECK(b.imbalance() == 130.0 / 100);
}

TEST_CASE("balance: a cut pays once its price is wasted, and not where it gains next to nothing") {
  constexpr double step = 27 * 8;  // grains of a rank: work of one DEM step
  // 700 DEM steps a look, as in 50 steps of 14; 1.25 instead of 1.05 wastes 140: more than the 130 that a cut costs.
  Balance b;
  CHECK(pays(b, 1.25, 1.05, 700 * step, step));
  // 0.15 of 500 a look: the second one pays.
  b = {};
  CHECK(!pays(b, 1.2, 1.05, 500 * step, step));
  CHECK(pays(b, 1.2, 1.05, 500 * step, step));
  // What was wasted before a cut is paid for.
  note_cut(b);
  CHECK(b.cuts == 1);
  CHECK(!pays(b, 1.2, 1.05, 500 * step, step));
  // Whole elements: no cut is better than this one, however long it lasts; and one that is worse takes nothing back.
  b = {};
  for (int k = 0; k < 1000; ++k) CHECK(!pays(b, 1.5, 1.45, 700 * step, step));
  b = {};
  CHECK(!pays(b, 1.2, 1.05, 500 * step, step));
  CHECK(!pays(b, 1.2, 1.6, 500 * step, step));
  CHECK(pays(b, 1.2, 1.05, 500 * step, step));
}

namespace {

Shard shard_of(std::vector<std::int64_t> elements) {
  Shard s;
  s.elements = std::move(elements);
  s.regions.resize(1);
  for (const std::int64_t e : s.elements) {  // two points each; of odd elements no grains
    for (int k = 0; k < 3; ++k) s.macro.push_back(static_cast<double>(100 * e + k));
    for (const std::int64_t point : {2 * e, 2 * e + 1})
      if (e % 2 == 0)
        s.rves.push_back(point);
      else
        s.regions[0].points.push_back(point), s.regions[0].bytes += std::to_string(1000 + point);
  }
  return s;
}

std::string rve_of(std::int64_t point) { return std::string(static_cast<std::size_t>(point), 'r'); }

}  // namespace

TEST_CASE("parcels: all that an element has goes to its new rank, and each RVE is asked for once") {
  const std::vector<std::int32_t> owners{2, 0, 0, 2, 2, 0};
  std::vector<std::vector<Parcel>> sent;
  std::map<std::int64_t, int> asked;
  for (const Shard& own : {shard_of({4, 0, 1}), shard_of({3, 2, 5})})
    sent.push_back(parcels(own, owners, 3, 2, [&](std::size_t k) {
      ++asked[own.rves[k]];
      return rve_of(own.rves[k]);
    }));
  CHECK(asked.size() == 6);
  for (const auto& [point, times] : asked) CHECK(times == 1);
  for (const auto& [rank, elements] :
       std::map<std::size_t, std::vector<std::int64_t>>{{0, {5, 1, 2}}, {1, {}}, {2, {3, 0, 4}}}) {
    const Shard whole = shard_of(elements);
    Shard got = whole;
    got.macro.clear(), got.regions[0].bytes.clear();
    std::map<std::size_t, std::string> rves;
    ShardFiller filler(got, [&](std::size_t k, const std::string& bytes) { rves[k] = bytes; });
    for (const auto& from : sent) filler.take("there", from[rank]);
    filler.end("there");
    CHECK(got.macro == whole.macro);
    CHECK(got.regions[0].bytes == whole.regions[0].bytes);
    REQUIRE(rves.size() == whole.rves.size());
    for (const auto& [k, bytes] : rves) CHECK(bytes == rve_of(whole.rves[k]));
    if (elements.empty()) continue;
    ShardFiller half(got, [](std::size_t, const std::string&) {});
    half.take("there", sent[0][rank]);
    CHECK_THROWS_AS(half.end("there"), grus::dem::InputError);  // the other rank's is missing
  }
}
