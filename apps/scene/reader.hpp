// SPDX-License-Identifier: LGPL-3.0-or-later
// Reads TOML tables key by key, with units, ranges, and errors that name file, line and key. What was read, defaults
// included, is recorded for summary.json. Keys nobody asked for are errors.
#pragma once

#include <toml++/toml.h>
#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/scene/keys.hpp"
#include "apps/scene/units.hpp"
#include "dem/base/error.hpp"

namespace grus::app {

using dem::InputError;

/// Bounds of a number; the message names the one that is broken.
struct Range {
  double low = -INFINITY, high = INFINITY;
  bool open_low = false, open_high = false;  // bound itself excluded
};
inline constexpr Range any{}, positive{0, INFINITY, true}, not_negative{0, INFINITY}, fraction{0, 1},
    proper_fraction{0, 1, true, true};

class Table {
public:
  Table(const toml::table& table, std::string file, std::string path, nlohmann::json& record);

  bool has(const std::string& key) const;
  double number(const std::string& key, const Dimension& dimension, const Range& range);  // required
  double number_or(const std::string& key, double fallback, const Dimension& dimension, const Range& range);
  long integer(const std::string& key, long low, long high);  // required
  long integer_or(const std::string& key, long fallback, long low, long high);
  bool flag_or(const std::string& key, bool fallback);
  std::string text(const std::string& key);
  std::string text_or(const std::string& key, const std::string& fallback);
  /// The path that a text names, beside the scene's file where it is relative.
  std::string path(const std::string& key);
  /// One of the words; the message lists them.
  std::string choice(const std::string& key, const std::vector<std::string>& words);
  std::string choice_or(const std::string& key, const std::string& fallback, const std::vector<std::string>& words);
  std::vector<double> numbers(const std::string& key, std::size_t count, const Dimension& dimension);  // required
  std::vector<double> numbers_or(const std::string& key, std::vector<double> fallback, const Dimension& dimension);
  /// Components that may be "free" (then empty).
  std::vector<std::optional<double>> free_numbers(const std::string& key, std::size_t count,
                                                  const Dimension& dimension);
  /// A list of [first, second] pairs, the second a plain number.
  std::vector<std::array<double, 2>> pairs(const std::string& key, const Dimension& first);
  /// A list of [x, y, z].
  std::vector<std::array<double, 3>> points(const std::string& key, const Dimension& dimension);
  std::vector<std::string> texts_or_none(const std::string& key);
  bool is_text(const std::string& key) const;
  std::size_t length(const std::string& key) const;  // of a list; 0: no list
  std::array<std::array<double, 3>, 3> matrix(const std::string& key, const Dimension& dimension);

  Table table(const std::string& key);  // required
  std::optional<Table> table_if(const std::string& key);
  std::vector<Table> tables(const std::string& key);  // [[key]], possibly none
  std::vector<std::string> table_names() const;       // sub-tables, in the order of the file

  /// Refuses keys that nobody read. Call when a table has been read.
  void finish() const;

  /// An InputError at a key, or at the table.
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;
  /// "file:line:column: key", or "file: --set key", for a fault that shows later.
  std::string place(const std::string& key) const;
  const std::string& file() const { return file_; }

private:
  const toml::node& node(const std::string& key);
  std::string word(const std::string& key);  // required, undeclared
  /// Holds what is read against the table of keys.
  void declare(const std::string& key, const char* type, const Dimension& dimension, const Range& range,
               const nlohmann::json& fallback = {}, const std::vector<std::string>& words = {}) const;
  double quantity(const toml::node& value, const std::string& key, const Dimension& dimension,
                  const Range& range) const;
  std::string path_of(const std::string& key) const { return (path_.empty() ? "" : path_ + ".") + as_in_toml(key); }
  std::string place_at(const toml::source_region& where, const std::string& key) const;
  /// Not from the file: it was given with the command, or by whoever reads this file for a purpose of his own.
  bool given(const toml::source_region& where) const { return where.path && *where.path != file_; }
  [[noreturn]] void fail_at(const toml::source_region& where, const std::string& key, const std::string& message) const;

  const toml::table* table_;
  std::string file_, path_;
  nlohmann::json* record_;
  std::set<std::string> known_;
};

/// Parses a file and applies `KEY=VALUE` overrides (dotted keys; a number counts into [[tables]]), which were given
/// `by` an option or key of that name: faults of theirs tell it.
toml::table parse_scene(const std::string& file, const std::vector<std::string>& overrides,
                        const std::string& by = "--set");

}  // namespace grus::app
