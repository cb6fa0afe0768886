// SPDX-License-Identifier: LGPL-3.0-or-later
// A scene file as TOML, with what --set changes in it.
#include <fmt/format.h>

#include <set>
#include <sstream>

#include "apps/scene/keys.hpp"
#include "apps/scene/reader.hpp"
#include "dem/base/text_file.hpp"

namespace grus::app {
namespace {

/// Refuses a key that is to be left out and is not there, where no scene knows its name.
void refuse_unknown(const std::string& by, const std::string& entry, const std::string& key) {
  std::set<std::string> names;
  for (const Key& known : scene_keys()) {
    std::string path = known.path;
    for (char& c : path)
      if (c == '.' || c == '[' || c == ']') c = ' ';
    std::istringstream words(path);
    for (std::string word; words >> word;) names.insert(word);
  }
  if (names.contains(key)) return;
  const std::string near = closest(key, {names.begin(), names.end()});
  throw InputError(fmt::format("{} {}: there is no '{}' to leave out{}", by, entry, key,
                               near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
}

/// VALUE as TOML, or as a text where it is a bare word or quantity. It remembers `place` instead of a line of a file.
toml::table parsed_value(const std::string& value, const std::string& place) {
  try {
    return toml::parse("v = " + value, place);
  } catch (const toml::parse_error&) {
    return toml::parse("v = " + nlohmann::json(value).dump(), place);
  }
}

}  // namespace

toml::table parse_scene(const std::string& file, const std::vector<std::string>& overrides, const std::string& by) {
  const auto in = dem::open_text(file);
  if (!in) throw InputError(fmt::format("{}: no such scene file", file));
  toml::table scene;
  try {
    scene = toml::parse(*in, file);
  } catch (const toml::parse_error& e) {
    throw InputError(
        fmt::format("{}:{}:{}: {}", file, e.source().begin.line, e.source().begin.column, e.description()));
  }
  for (const auto& entry : overrides) {
    const auto equals = entry.find('=');
    if (equals == std::string::npos || equals == 0)
      throw InputError(fmt::format("{} {}: expected KEY=VALUE", by, entry));
    const std::string value = entry.substr(equals + 1);
    std::string rest = entry.substr(0, equals);
    toml::table parsed;
    if (!value.empty()) parsed = parsed_value(value, fmt::format("{} {}", by, rest));
    toml::node* at = &scene;
    while (true) {
      const auto dot = rest.find('.');
      const std::string key = rest.substr(0, dot);
      if (auto* list = at->as_array()) {
        const bool digits = !key.empty() && key.find_first_not_of("0123456789") == std::string::npos;
        const std::size_t number = digits && key.size() < 10 ? std::stoul(key) : SIZE_MAX;
        if (number >= list->size())
          throw InputError(fmt::format("{} {}: '{}' is not one of {} entries", by, entry, key, list->size()));
        at = list->get(number);
        if (dot == std::string::npos) throw InputError(fmt::format("{} {}: name a key of the entry", by, entry));
      } else if (auto* table = at->as_table()) {
        if (dot == std::string::npos) {
          if (value.empty()) {  // KEY= leaves the key, or the whole table, out
            if (table->erase(key) == 0) refuse_unknown(by, entry, key);
          } else {
            parsed.get("v")->visit([&](auto& v) { table->insert_or_assign(key, std::move(v)); });  // with its place
          }
          break;
        }
        if (!table->contains(key)) table->insert(key, toml::table{});
        at = table->get(key);
      } else {
        throw InputError(fmt::format("{} {}: '{}' is below a value, not a table", by, entry, key));
      }
      rest = rest.substr(dot + 1);
    }
  }
  return scene;
}

}  // namespace grus::app
