// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/run/same_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "apps/scene/keys.hpp"
#include "dem/base/error.hpp"

namespace grus::app {
namespace {

constexpr std::size_t most_told = 20, longest_table = 60;

bool of_tables(const nlohmann::json& v) { return v.is_array() && !v.empty() && v[0].is_object(); }

/// A table that is there in one scene only is told whole where it is short.
std::string value_text(const nlohmann::json& v) {
  if (v.is_null()) return "absent";
  const std::string whole = v.dump();
  return v.is_object() && whole.size() > longest_table ? fmt::format("a table of {} keys", v.size()) : whole;
}

struct Change {
  std::string text;
  bool follows;  // a default that comes or goes, as another key is given or not
};

/// Each key that differs, as the scene writes it, with both values.
void compare(const std::string& key, const nlohmann::json& kept, const nlohmann::json& now,
             std::vector<Change>& changes) {
  if (kept == now) return;
  if (kept.is_object() && now.is_object()) {
    std::set<std::string> names;
    for (const auto& [name, _] : kept.items()) names.insert(name);
    for (const auto& [name, _] : now.items()) names.insert(name);
    if (key.empty()) names.erase("title");
    for (const auto& name : names)
      compare(key.empty() ? name : fmt::format("{}.{}", key, name), kept.value(name, nlohmann::json()),
              now.value(name, nlohmann::json()), changes);
  } else if (kept.is_array() && now.is_array() && (of_tables(kept) || of_tables(now))) {
    for (std::size_t k = 0; k < std::max(kept.size(), now.size()); ++k)
      compare(fmt::format("{}[{}]", key, k), k < kept.size() ? kept[k] : nlohmann::json(),
              k < now.size() ? now[k] : nlohmann::json(), changes);
  } else {
    const bool follows = (now.is_null() && is_default(key, kept)) || (kept.is_null() && is_default(key, now));
    changes.push_back({fmt::format("{} was {}, is {}", key, value_text(kept), value_text(now)), follows});
  }
}

}  // namespace

void refuse_changes(const std::string& path, const nlohmann::json& kept, const nlohmann::json& now,
                    const std::string& of, const std::string& advice) {
  if (kept.is_object() != now.is_object()) throw dem::InputError(path + ": checkpoint of another scene");
  std::vector<Change> found;
  compare("", kept, now, found);
  if (found.empty()) return;
  const bool all = std::all_of(found.begin(), found.end(), [](const Change& c) { return c.follows; });
  std::vector<std::string> changes;
  for (const Change& c : found)
    if (all || !c.follows) changes.push_back(c.text);
  const std::size_t more = changes.size() > most_told ? changes.size() - most_told : 0;
  if (more > 0) changes.resize(most_told);
  throw dem::InputError(fmt::format("{}: checkpoint of another scene: {}{}{}; {}", path, of.empty() ? "" : of + ": ",
                                    fmt::join(changes, "; "), more > 0 ? fmt::format("; and {} more", more) : "",
                                    advice));
}

bool has_finished(const std::string& folder, const nlohmann::json* scene) {
  std::ifstream in(folder + "/summary.json");
  const nlohmann::json summary = nlohmann::json::parse(in, nullptr, false);
  if (!summary.is_object() || summary.value("status", nlohmann::json()) != 0) return false;
  if (scene == nullptr) return true;
  nlohmann::json kept = summary.value("scene", nlohmann::json()), now = *scene;
  for (nlohmann::json* of : {&kept, &now})
    if (of->is_object()) of->erase("title");
  return kept == now;
}

}  // namespace grus::app
