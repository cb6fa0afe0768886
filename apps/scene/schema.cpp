// SPDX-License-Identifier: LGPL-3.0-or-later
// The table of keys as a JSON schema.
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/scene/keys.hpp"

namespace grus::app {
namespace {

using nlohmann::json;

/// Bounds of "> 0", ">= 0", "< 1", "0 < x <= 1"; none where they depend on other keys.
void add_range(const std::string& range, json& number) {
  if (range.empty() || range.starts_with('~') || range.find(" or ") != std::string::npos) return;
  double a = 0, b = 0;
  char first[3] = "", second[3] = "";
  const auto low = [&](const std::string& sign) { return sign == "<" || sign == ">" ? "exclusiveMinimum" : "minimum"; };
  if (std::sscanf(range.c_str(), "%lf %2[<=] x %2[<=] %lf", &a, first, second, &b) == 4) {
    number[low(first)] = a;
    number[std::string(second) == "<" ? "exclusiveMaximum" : "maximum"] = b;
  } else if (std::sscanf(range.c_str(), "%2[>=] %lf", first, &a) == 2) {
    number[low(first)] = a;
  }
}

/// A number, or a text with a unit.
json quantity(const Key& k) {
  json number{{"type", "number"}};
  add_range(k.range, number);
  const json text{{"type", "string"}, {"pattern", "^ *[-+]?[0-9.]"}};
  return {{"anyOf", json::array({number, text})}};
}

json list_of(json item) { return {{"type", "array"}, {"items", std::move(item)}}; }

json of_type(const std::string& type, const Key& k) {
  if (type == "number") return quantity(k);
  if (type == "integer") {
    json integer{{"type", "integer"}};
    add_range(k.range, integer);
    return integer;
  }
  if (type == "flag") return {{"type", "boolean"}};
  if (type == "text") return {{"type", "string"}};
  if (type == "texts") return list_of({{"type", "string"}});
  if (type == "choice") {
    json words = json::array();
    std::string word;
    for (const char c : k.words + "|")
      if (c == '|')
        words.push_back(word), word.clear();
      else if (c != '~')
        word += c;
    return {{"enum", words}};
  }
  if (type == "list") return list_of(quantity(k));
  if (type == "free-list") return list_of({{"anyOf", json::array({quantity(k), json{{"const", "free"}}})}});
  if (type == "table") return {{"type", "object"}};
  if (type == "tables") return list_of({{"type", "object"}});
  return list_of(list_of(quantity(k)));  // pairs, points, matrix
}

json of_key(const Key& k) {
  json any = json::array();
  std::size_t from = 0;
  for (std::size_t at; from <= k.type.size(); from = at + 4) {
    at = std::min(k.type.find(" or ", from), k.type.size());
    any.push_back(of_type(k.type.substr(from, at - from), k));
  }
  json schema = any.size() == 1 ? any[0] : json{{"anyOf", any}};
  schema["description"] = k.meaning;
  if (!k.fallback.empty() && !k.fallback.starts_with('~')) schema["default"] = json::parse(k.fallback);
  return schema;
}

/// Puts what a key's last part stands for below its parents, which come before it.
void place(json& root, const std::string& path, const json& schema) {
  json* at = &root;
  std::size_t from = 0;
  while (true) {
    const std::size_t dot = path.find('.', from);
    std::string part = path.substr(from, dot == std::string::npos ? dot : dot - from);
    const bool listed = part.ends_with("[]");
    if (listed) part.resize(part.size() - 2);
    json& next = part == "*" ? (*at)["additionalProperties"] : (*at)["properties"][part];
    if (part != "*" && !at->contains("additionalProperties")) (*at)["additionalProperties"] = false;
    if (dot == std::string::npos) {
      if (next.is_null() || next.is_boolean()) next = json::object();
      next.update(schema);
      return;
    }
    if (next.is_null() || next.is_boolean()) next = json::object();
    json* below = listed ? &next["items"] : &next;
    if (below->contains("anyOf"))  // a table or something else
      for (json& one : (*below)["anyOf"])
        if (one.value("type", json()) == "object") below = &one;
    at = below;
    from = dot + 1;
  }
}

}  // namespace

json scene_schema(const std::string& program) {
  json schema{{"$schema", "http://json-schema.org/draft-07/schema#"},
              {"title", program == "bvp" ? "Grus: a boundary-value problem" : "Grus: a DEM test"},
              {"type", "object"}};
  for (const Key& k : keys_of(program)) {
    Key of_program = k;
    if (k.path == "boundary") of_program.type = program == "bvp" ? "tables" : "table";
    place(schema, k.path, of_key(of_program));
  }
  if (program == "rve") schema["properties"]["packing"]["properties"]["parents"] = {{"type", "object"}};
  return schema;
}

}  // namespace grus::app
