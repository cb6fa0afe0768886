// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/run/about_scenes.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include <new_scenes.hpp>  // made by CMake
#include "apps/scene/keys.hpp"
#include "dem/base/error.hpp"
#include "dem/io/whole_file.hpp"

namespace grus::app {

void add_about(CLI::App& cli, const std::string& program, About& about) {
  cli.add_option_function<std::vector<std::string>>(
         "--keys", [&about](const std::vector<std::string>& part) { about.keys = part.empty() ? "" : part[0]; },
         "print every key of a scene with unit, range, default and example (those that hold TEXT), stop")
      ->expected(0, 1)
      ->type_name("[TEXT]");
  cli.add_flag("--schema", about.schema, "print the JSON schema of scenes, for editors, stop");
  if (program != "rve") return;
  std::vector<std::string> kinds;
  for (const auto& [kind, text] : new_scenes) kinds.push_back(kind);
  cli.add_option("--new", about.kind, "write a commented scene to SCENE (default: KIND.toml), stop")
      ->type_name("KIND")
      ->check(CLI::IsMember(kinds));
}

void tell(const About& about, const std::string& program, const std::string& file) {
  if (about.keys) {
    const std::string listing = keys_listing(program, *about.keys);
    if (listing.empty()) throw dem::InputError(fmt::format("--keys {}: no key holds that", *about.keys));
    fmt::print("{}", listing);
  }
  if (about.schema) fmt::print("{}\n", scene_schema(program).dump(1));
  if (about.kind.empty()) return;
  const std::string path = file.empty() ? about.kind + ".toml" : file;
  if (std::filesystem::exists(path))
    throw dem::InputError(fmt::format("{}: is there already; name another file", path));
  dem::write_whole(path, new_scenes.at(about.kind));
  const std::string folder = std::filesystem::path(path).stem().string();
  fmt::print("{0}: grus check {0}, grus run {0}, grus report {1}\n", path, folder);
}

}  // namespace grus::app
