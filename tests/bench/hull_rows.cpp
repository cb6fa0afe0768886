// SPDX-License-Identifier: LGPL-3.0-or-later
// What grus_bench --hulls tells: a row for each goal, of an order that any machine has. How fast it is is no test.
#include "tests/bench/hull_works.hpp"
#include "tests/helpers.hpp"

using namespace grus::bench;

TEST_CASE("each goal of hulls has its rows, of a plausible order") {
  std::vector<Row> rows;
  time_hulls(20, [&](Row row) { rows.push_back(std::move(row)); });
  const char *const names[] = {"angular hulls, angular_rve.toml (126)", "broken hulls (", "Voronoi cells, unbonded"};
  const double least[] = {2.5, 3, 6}, most[] = {4.5, 5.5, 9};  // contacts a grain: docs/benchmarks.md has 3.6, 3.9, 7.5
  REQUIRE(rows.size() == 9);
  for (std::size_t k = 0; k < 3; ++k) {
    const Row *const speed = &rows[3 * k], *const contacts = speed + 1, *const pass = speed + 2;
    CHECK(speed->work.starts_with(names[k]));
    CHECK(speed->unit == "10^6 grain-steps/s");
    CHECK((speed->value > 1e-4 && speed->value < 10));
    CHECK((contacts->value > least[k] && contacts->value < most[k]));
    CHECK(pass->unit == "ns");
    CHECK((pass->value > 20 && pass->value < 1e6));
  }
}
