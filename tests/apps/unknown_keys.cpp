// SPDX-License-Identifier: LGPL-3.0-or-later
// No table of a scene takes a key that it does not know: a misspelt one would be left out without a word.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "apps/bvp/scene/bvp_scene.hpp"
#include "apps/scene/keys.hpp"
#include "tests/apps/refused.hpp"

using namespace grus::app;

namespace {

const std::string rock = R"(
material.rock.density = 2500
material.rock.contact = "overlap"
material.rock.friction = 0.3
material.rock.bond = { modulus = "10 GPa", tension = "2 MPa", cohesion = "3 MPa", fracture_energy = 5 }
loading = { kind = "free", duration = 1 }
)";

const std::string sand = R"(
material.sand = { density = 2500, youngs_modulus = "9 GPa", friction = 0.5 }
boundary.kind = "periodic"
[loading]
kind = "free"
duration = 1
[packing]
kind = "random"
box = ["10 mm", "12 mm", "14 mm"]
radius = { distribution = "constant", mean = "0.5 mm" }
solid_fraction = 0.3
)";

const std::string block = R"(
mesh.box = { size = [1, 1, 1], cells = [2, 2, 2] }
boundary = [{ where = "z=min", displacement = [0, 0, 0] }]
rve = { scene = "cell.toml" }
)";

/// Tables that the scenes of apps/scenes do not have: a scene of grus-bvp or of grus-rve, and what it is changed by.
struct More {
  bool macro;
  std::string text;
  std::vector<std::string> sets;
};
const std::vector<More> more{
    {false, rock, {"packing={kind=\"voronoi\", cells=20, prism={corners=[[0,0,0],[6,0,0],[0,6,0]], height=3}}"}},
    {false, rock, {"packing={kind=\"voronoi\", cells=20, polyellipsoid={semi_axes=[3,2,2,2,2,2]}}"}},
    {false, sand, {"packing.mixture=[{material=\"sand\", share=1}]"}},
    {false,
     sand,
     {"material.sand={density=2500, youngs_modulus=\"9 GPa\", fracture={model=\"polyellipsoid-split\", "
      "hoek_brown={compressive_strength=\"9 MPa\", m=20}, shape_transition={ratio=0.3, time=1e-5}}}"}},
    {false,
     "grain = [{ shape = \"hull\", box = [1, 1, 1], position = [0, 0, 0] }]\nloading = { kind = \"free\", duration = 1 "
     "}"
     "\nmaterial.rock = { density = 2600, contact = \"overlap\", youngs_modulus = 1e9 }\n",
     {"material.rock={density=2600, contact=\"overlap\", youngs_modulus=1e10, fracture={model=\"peridynamics\", "
      "platen_strength=\"20 MPa\", crack={}, test={}}}"}},
    {false, rock, {"packing={kind=\"polyhedra\", path=\"cubes.obj\", group=[{name=\"one\", material=\"rock\"}]}"}},
    {true, block, {"solve.kind=\"quasi-static\"", "rve.adaptivity={error=0.1}"}},
    {true, block, {"solve.kind=\"explicit-quasi-static\"", "regularisation.length=0.1"}}};

const char* const cube =
    "g one\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
    "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

/// Where a table stands in the list of keys: "material.*", "grain[]".
using Places = std::vector<std::pair<std::string, std::string>>;  // as --set has it, as the list has it

void find_tables(const nlohmann::json& record, const std::string& path, const std::string& key, Places& found) {
  if (record.is_array()) {
    for (std::size_t i = 0; i < record.size(); ++i)
      if (record[i].is_object()) find_tables(record[i], fmt::format("{}.{}", path, i), key + "[]", found);
    return;
  }
  if (!record.is_object()) return;
  if (!path.empty() && path != "material") found.emplace_back(path, key);
  for (const auto& [name, value] : record.items()) {
    const std::string dot = path.empty() ? "" : ".";
    find_tables(value, path + dot + as_in_toml(name), path == "material" ? "material.*" : key + dot + name, found);
  }
}

/// Every table of the list.
std::set<std::string> all_tables() {
  std::set<std::string> tables;
  for (const Key& k : scene_keys())
    if (const auto dot = k.path.rfind('.'); dot != std::string::npos) tables.insert(k.path.substr(0, dot));
  tables.erase("material");
  return tables;
}

template <class Read>
void check_tables(Read&& read, const std::string& file, const std::vector<std::string>& sets,
                  std::set<std::string>& known) {
  INFO(file << (sets.empty() ? "" : ", " + sets.back()));
  Places tables;
  find_tables(read(file, sets), "", "", tables);
  CHECK(tables.size() > 1);
  for (const auto& [path, key] : tables) {
    if (!known.insert(key).second) continue;  // once is enough
    auto with = sets;
    with.push_back(path + ".nobody=1");
    INFO(with.back());
    CHECK_THROWS_WITH(read(file, with), Catch::Contains(".nobody: unknown key"));
  }
}

}  // namespace

TEST_CASE("no table of a scene takes a key that it does not know, whichever of all the tables there are it is") {
  std::set<std::string> known;
  const auto rve = [](const std::string& file, const std::vector<std::string>& sets) {
    return *read_rve_scene(file, sets).record;
  };
  const auto bvp = [](const std::string& file, const std::vector<std::string>& sets) {
    return *read_bvp_scene(file, sets).record;
  };
  for (const auto& entry : std::filesystem::recursive_directory_iterator(GRUS_SCENES)) {
    const std::string file = entry.path().string();
    if (entry.path().extension() != ".toml" || file.find("/studies/") != std::string::npos) continue;
    std::ifstream in(file);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (text.find("\n[solve]") != std::string::npos)
      check_tables(bvp, file, {}, known);
    else if (text.find("\n[loading]") != std::string::npos || text.find("\n[[stage]]") != std::string::npos)
      check_tables(rve, file, {}, known);
  }
  const test::Scratch scratch;
  std::ofstream(scratch.path + "/cubes.obj") << cube;
  std::ofstream(scratch.path + "/cell.toml")
      << sand.substr(0, sand.find("[loading]")) + sand.substr(sand.find("[packing]"));
  for (const auto& [macro, text, sets] : more) {
    const std::string file = scratch.path + "/scene.toml";
    std::ofstream(file) << text;
    macro ? check_tables(bvp, file, sets, known) : check_tables(rve, file, sets, known);
  }
  std::ofstream(scratch.path + "/scene.toml") << sand;
  CHECK_THROWS_WITH(rve(scratch.path + "/scene.toml", {"nobody=1"}), Catch::Contains("nobody: unknown key"));
  std::ofstream(scratch.path + "/scene.toml") << block;
  CHECK_THROWS_WITH(bvp(scratch.path + "/scene.toml", {"nobody=1", "solve.kind=\"quasi-static\""}),
                    Catch::Contains("nobody: unknown key"));
  for (const std::string& table : all_tables()) {
    INFO(table << " is in no scene of this test");
    CHECK(known.contains(table));
  }
}
