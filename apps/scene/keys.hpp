// SPDX-License-Identifier: LGPL-3.0-or-later
// The table of all keys of scenes (keys.txt). In tests the reader holds every key that it reads against it, so that
// what is said of a key - in --keys, in the schema, in the documents - is what is read.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace grus::app {

/// A row. Of `type`, `unit`, `range` there may be several, with " or " between. A "~" before `range`, `fallback` or
/// `words` says that it depends on other keys, and how in words.
struct Key {
  std::string path;      // material.*.density, grain[].radius
  std::string type;      // number, integer, flag, text, choice, list, free-list,
                         // pairs, points, texts, matrix, table, tables
  std::string unit;      // what the number is: length, stress, ...
  std::string range;     // "> 0", "0 <= x < 1"
  std::string fallback;  // as JSON; empty: none
  std::string words;     // of a choice, with "|" between
  std::string example, meaning;
};

const std::vector<Key>& scene_keys();

/// A key as a path has it: quoted where TOML wants that, so that a name may hold dots.
std::string as_in_toml(const std::string& key);

/// Facts of a key as it is read. Where the environment has GRUS_CHECK_KEYS, as that of the tests has: throws
/// std::logic_error where the table has no such key or says otherwise. A run of a user looks at no table.
void check_key(const std::string& path, const Key& read, const nlohmann::json& fallback);

/// The row of a key; null where the table has none.
const Key* row_of(const std::string& path);

/// Whether a key has this value where no scene gives it.
bool is_default(const std::string& path, const nlohmann::json& value);

/// The keys that grus-rve ("rve") or grus-bvp ("bvp") reads.
std::vector<Key> keys_of(const std::string& program);

/// Them as text for a terminal; those alone whose path or meaning holds `part`.
std::string keys_listing(const std::string& program, const std::string& part);

/// Their JSON schema (draft 7), by which editors complete and check scenes.
nlohmann::json scene_schema(const std::string& program);

}  // namespace grus::app
