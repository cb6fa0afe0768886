// SPDX-License-Identifier: LGPL-3.0-or-later
// What is told of a checkpoint that is of another scene.
#include "apps/run/same_scene.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "dem/base/error.hpp"
#include "tests/apps/scratch.hpp"
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
  const json one = json::parse(R"({"title": "a", "seed": 7, "stage": [{"kind": "relax", "rows": 2}], "box": [1, 2]})");
  json other = one;
  other["title"] = "b";
  CHECK(refused(one, other).empty());
  const std::string head = "c.h5: checkpoint of another scene: ", tail = "; set it back, or begin anew with --force";
  other["stage"][0]["rows"] = 3;
  CHECK(refused(one, other) == head + "stage[0].rows was 2, is 3" + tail);
  other = one, other["stage"].push_back({{"kind", "hold"}});
  CHECK(refused(one, other) == head + "stage[1] was absent, is {\"kind\":\"hold\"}" + tail);
  other["stage"][1] = {{"kind", "compress"}, {"pressure", 1e6}, {"friction", 0.1}, {"until", "a stress of 1 MPa"}};
  CHECK(refused(one, other) == head + "stage[1] was absent, is a table of 4 keys" + tail);
  other = one, other["box"] = {1, 3}, other.erase("seed");
  CHECK(refused(one, other) == head + "box was [1,2], is [1,3]; seed was 7, is absent" + tail);
  // A default that is there because of another key is not what was changed.
  const json spread = json::parse(R"({"solve": {"kind": "quasi-static", "patience": 600.0, "spread": true}})");
  json alone = spread;
  alone["solve"].erase("spread"), alone["solve"].erase("patience");
  CHECK(refused(spread, alone) == head + "solve.spread was true, is absent" + tail);
  CHECK(refused(alone, spread) == head + "solve.spread was absent, is true" + tail);
  alone = spread, alone["solve"]["patience"] = 60.0;
  CHECK(refused(spread, alone) == head + "solve.patience was 600.0, is 60.0" + tail);
}

TEST_CASE("a run that has finished is known by its summary: of this scene, whatever its title") {
  const grus::app::test::Scratch scratch;
  using nlohmann::json;
  const json scene = {{"title", "a"}, {"seed", 1}}, titled = {{"title", "b"}, {"seed", 1}}, other = {{"seed", 2}};
  CHECK_FALSE(has_finished(scratch.path, &scene));  // no summary
  for (const int status : {0, 75, 130}) {
    std::ofstream(scratch.path + "/summary.json") << json{{"status", status}, {"scene", scene}}.dump();
    CHECK(has_finished(scratch.path, &scene) == (status == 0));
    CHECK(has_finished(scratch.path, &titled) == (status == 0));
    CHECK(has_finished(scratch.path) == (status == 0));
    CHECK_FALSE(has_finished(scratch.path, &other));
  }
  std::ofstream(scratch.path + "/summary.json") << "[]";
  CHECK_FALSE(has_finished(scratch.path));
}
