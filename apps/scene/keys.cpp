// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include <scene_keys_text.hpp>  // made by CMake
#include "dem/base/tensor.hpp"

namespace grus::app {
namespace {

std::vector<std::string> split(const std::string& text, const std::string& by) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  for (std::size_t at; (at = text.find(by, from)) != std::string::npos; from = at + by.size())
    parts.push_back(text.substr(from, at - from));
  parts.push_back(text.substr(from));
  return parts;
}

bool holds(const std::vector<std::string>& list, const std::string& item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

bool depends(const std::string& fact) { return fact.starts_with('~'); }

std::vector<Key> parsed() {
  std::vector<Key> keys;
  for (const std::string& line : split(keys_text, "\n")) {
    if (line.empty()) continue;
    const auto field = split(line, " | ");
    if (field.size() != 8) throw std::logic_error("keys.txt: not eight fields: " + line);
    keys.push_back({field[0], field[1], field[2], field[3], field[4], field[5], field[6], field[7]});
  }
  return keys;
}

/// material.sand.density is material.*.density, grain[3].radius grain[].radius; a packing's parents are a packing.
std::string general(std::string path) {
  if (const std::string quoted = "material.\""; path.starts_with(quoted)) {  // such a name may hold dots
    std::size_t end = quoted.size();
    while (end < path.size() && path[end] != '"') end += path[end] == '\\' ? 2u : 1u;
    path = "material.*" + (end < path.size() ? path.substr(end + 1) : "");
  }
  std::string text;
  const auto parts = split(path, ".");
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::size_t bracket = parts[i].find('[');
    const std::string part = i == 1 && parts[0] == "material" ? "*"
                             : bracket == std::string::npos   ? parts[i]
                                                              : parts[i].substr(0, bracket) + "[]";
    if (i > 1 && i + 1 <= parts.size() && parts[0] == "packing" && parts[i - 1] == "parents")
      text = "packing";  // what follows is read as of a packing of its own
    text += (text.empty() ? "" : ".") + part;
  }
  return text;
}

const Key* find(const std::string& path) {
  const auto& keys = scene_keys();
  const auto at = std::find_if(keys.begin(), keys.end(), [&](const Key& k) { return k.path == path; });
  return at == keys.end() ? nullptr : &*at;
}

/// Bounds of an angle as people write them: "0 <= x <= 1.53938" is "0 deg <= x <= 88.2 deg".
std::string in_degrees(const std::string& range) {
  std::string text;
  for (const std::string& word : split(range, " ")) {
    char* end = nullptr;
    const double radians = std::strtod(word.c_str(), &end);
    if (!text.empty()) text += " ";
    text += end == word.c_str() || *end != '\0' ? word : fmt::format("{:.3g} deg", radians * 180 / dem::pi);
  }
  return text;
}

/// What of a row is not as read; empty: nothing.
std::string difference(const Key& row, const Key& read, const nlohmann::json& fallback) {
  if (!holds(split(row.type, " or "), read.type)) return "type " + read.type;
  if (!read.unit.empty() && !holds(split(row.unit, " or "), read.unit)) return "unit " + read.unit;
  if (!read.range.empty() && !depends(row.range) && !holds(split(row.range, " or "), read.range))
    return "range " + read.range;
  if (!fallback.is_null() && !depends(row.fallback) &&
      (row.fallback.empty() || nlohmann::json::parse(row.fallback) != fallback))
    return "default " + fallback.dump();
  if (read.words.empty()) return "";
  if (!depends(row.words)) return row.words == read.words ? "" : "words " + read.words;
  const auto known = split(row.words.substr(1), "|");
  for (const auto& word : split(read.words, "|"))
    if (!holds(known, word)) return "word " + word;
  return "";
}

}  // namespace

std::string as_in_toml(const std::string& key) {
  const bool bare = std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare && !key.empty() ? key : nlohmann::json(key).dump();
}

const std::vector<Key>& scene_keys() {
  static const std::vector<Key> keys = parsed();
  return keys;
}

void check_key(const std::string& path, const Key& read, const nlohmann::json& fallback) {
  static const bool asked = std::getenv("GRUS_CHECK_KEYS") != nullptr;  // by the tests: no run ends over the table
  if (!asked) return;
  const Key* row = row_of(path);
  if (row == nullptr) throw std::logic_error(fmt::format("apps/scene/keys.txt has no row for {}", general(path)));
  if (const std::string found = difference(*row, read, fallback); !found.empty())
    throw std::logic_error(fmt::format("apps/scene/keys.txt of {}: the reader has {}", row->path, found));
}

const Key* row_of(const std::string& path) { return find(general(path)); }

bool is_default(const std::string& path, const nlohmann::json& value) {
  const Key* row = row_of(path);
  return row != nullptr && !row->fallback.empty() && !depends(row->fallback) &&
         nlohmann::json::parse(row->fallback) == value;
}

std::vector<Key> keys_of(const std::string& program) {
  static const std::array macro{"mesh", "element", "initial_stress", "region",        "solve",
                                "rve",  "probe",   "hopkinson",      "regularisation"};
  std::vector<Key> keys;
  for (const Key& k : scene_keys()) {
    const std::string table = split(k.path, ".")[0];
    const bool shared = k.path == "title" || k.path == "output" || k.path == "output.frames" ||
                        k.path == "output.checkpoint_interval" || k.path == "output.history_interval" ||
                        k.path == "boundary";
    const bool of_macro = table == "boundary[]" || k.path == "gravity" || k.path == "output.costs" ||
                          std::any_of(macro.begin(), macro.end(),
                                      [&](const std::string& name) { return table == name || table == name + "[]"; });
    if (shared || of_macro == (program == "bvp")) keys.push_back(k);
  }
  return keys;
}

std::string keys_listing(const std::string& program, const std::string& part) {
  std::string text, table;
  for (const Key& k : keys_of(program)) {
    if (k.path.find(part) == std::string::npos && k.meaning.find(part) == std::string::npos) continue;
    if (k.type == "table" || k.type == "tables") {
      text += fmt::format("\n{}\n    {}\n", k.type == "table" ? "[" + k.path + "]" : "[[" + k.path + "]]", k.meaning);
      continue;
    }
    const auto plain = [](const std::string& fact) { return depends(fact) ? fact.substr(1) : fact; };
    std::string facts = k.words.empty() ? k.type : plain(k.words);
    if (!k.unit.empty() && k.unit != "number") facts += " (" + k.unit + ")";
    if (!k.range.empty()) facts += ", " + (k.unit == "angle" ? in_degrees(k.range) : plain(k.range));
    if (!k.fallback.empty()) facts += "; default " + plain(k.fallback);
    text += fmt::format("{}\n    {}\n    {}\n", k.path, k.meaning, facts);
    if (!k.example.empty()) text += fmt::format("    {} = {}\n", k.path.substr(k.path.rfind('.') + 1), k.example);
  }
  return text;
}

}  // namespace grus::app
