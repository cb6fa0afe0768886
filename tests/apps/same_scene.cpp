// SPDX-License-Identifier: LGPL-3.0-or-later
// What is told of a checkpoint that is of another scene.
#include "apps/run/same_scene.hpp"

#include <nlohmann/json.hpp>

#include "dem/base/error.hpp"
#include "tests/helpers.hpp"

using namespace grus;
using namespace grus::app;

TEST_CASE("a checkpoint of another scene names each key that has changed, of lists of tables by their number") {
  using nlohmann::json;
  const auto refused = [](const json& kept, const json& now) {
    try {
      refuse_changes("c.h5", kept, now);
    } catch (const dem::InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const json one = json::parse(R"({"title": "a", "seed": 1, "stage": [{"kind": "relax", "rows": 2}], "box": [1, 2]})");
  json other = one;
  other["title"] = "b";
  CHECK(refused(one, other).empty());
  const std::string head = "c.h5: checkpoint of another scene: ", tail = "; set it back, or begin anew with --force";
  other["stage"][0]["rows"] = 3;
  CHECK(refused(one, other) == head + "stage[0].rows was 2, is 3" + tail);
  other = one, other["stage"].push_back({{"kind", "hold"}});
  CHECK(refused(one, other) == head + "stage[1] was absent, is {\"kind\":\"hold\"}" + tail);
  other = one, other["box"] = {1, 3}, other.erase("seed");
  CHECK(refused(one, other) == head + "box was [1,2], is [1,3]; seed was 1, is absent" + tail);
}
