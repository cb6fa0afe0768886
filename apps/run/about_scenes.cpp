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

namespace {

/// Files of one kind, the first as `file` says; none where one of them is there already.
void write_new(const std::vector<NewFile>& files, const std::string& kind, const std::string& file) {
  const std::filesystem::path first = file.empty() ? kind + files.front().ending : file;
  const std::string name = first.stem().string();
  const bool program = files.front().ending == std::string_view(".py");
  if (files.size() > 1 && name.find_first_of("\"\\\n") != std::string::npos)
    throw dem::InputError("--new: a name without quotes, backslashes and line ends is wanted: the first file names it");
  if (program && first.extension() != ".py") throw dem::InputError(fmt::format("--new {}: its name ends in .py", kind));
  constexpr std::string_view mark = "%NAME%";
  const auto path_of = [&](const NewFile& f) {
    return &f == &files.front() ? first : first.parent_path() / (name + f.ending);
  };
  for (const NewFile& f : files)
    if (std::filesystem::exists(path_of(f)))
      throw dem::InputError(fmt::format("{}: is there already; name another file", path_of(f).string()));
  for (const NewFile& f : files) {
    std::string text = f.text;
    for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos; at += name.size())
      text.replace(at, mark.size(), name);
    dem::write_whole(path_of(f).string(), text);
  }
  if (program)
    fmt::print("{0}: /usr/bin/python3 {0}\n", first.string());
  else
    fmt::print("{0}: grus check {0}, grus run {0}, grus report {1}\n", first.string(), name);
}

}  // namespace

void add_about(CLI::App& cli, const std::string& program, About& about) {
  cli.add_option_function<std::vector<std::string>>(
         "--keys", [&about](const std::vector<std::string>& part) { about.keys = part.empty() ? "" : part[0]; },
         "print every key of a scene with unit, range, default and example (those that hold TEXT), stop")
      ->expected(0, 1)
      ->type_name("[TEXT]");
  cli.add_flag("--schema", about.schema, "print the JSON schema of scenes, for editors, stop");
  std::vector<std::string> kinds;
  for (const auto& [kind, files] : new_scenes.at(program)) kinds.push_back(kind);
  const char* what = program == "rve" ? "write a commented scene to SCENE (default: KIND.toml), stop"
                                      : "write a commented scene to SCENE (default: KIND.toml) with the scene of its "
                                        "RVEs beside it, or a program of DOLFINx (block-dolfinx.py), stop";
  cli.add_option("--new", about.kind, what)->type_name("KIND")->check(CLI::IsMember(kinds));
}

void tell(const About& about, const std::string& program, const std::string& file) {
  if (about.keys) {
    const std::string listing = keys_listing(program, *about.keys);
    if (listing.empty()) throw dem::InputError(fmt::format("--keys {}: no key holds that", *about.keys));
    fmt::print("{}", listing);
  }
  if (about.schema) fmt::print("{}\n", scene_schema(program).dump(1));
  if (about.kind.empty()) return;
  write_new(new_scenes.at(program).at(about.kind), about.kind, file);
}

}  // namespace grus::app
