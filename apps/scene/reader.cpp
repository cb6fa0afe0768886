// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

namespace grus::app {
namespace {

/// What is said of a text that was meant as a list: --set takes as a text what is no value.
const char* in_quotes(const toml::node& n) {
  const bool list = n.is_string() && n.as_string()->get().starts_with('[');
  return list ? ", those that are texts or have a unit in quotes" : "";
}

std::string shown(const toml::node& node) {
  std::ostringstream out;
  if (const auto* s = node.as_string())
    out << '"' << s->get() << '"';
  else if (const auto* x = node.as_floating_point())
    out << fmt::format("{}", x->get());
  else
    node.visit([&](const auto& n) {
      if constexpr (toml::is_value<decltype(n)>) out << n;
    });
  return out.str();
}

/// As the table of keys has it; empty: any number.
std::string range_text(const Range& r) {
  const bool above = std::isfinite(r.low), below = std::isfinite(r.high);
  if (above && below)
    return fmt::format("{:g} {} x {} {:g}", r.low, r.open_low ? "<" : "<=", r.open_high ? "<" : "<=", r.high);
  if (above) return fmt::format("{} {:g}", r.open_low ? ">" : ">=", r.low);
  return below ? fmt::format("{} {:g}", r.open_high ? "<" : "<=", r.high) : "";
}

/// "--set boundary.0.pressure"; with the key where that is below what was given.
std::string place_given(const std::string& place, const std::string& key) {
  std::string dotted;
  for (const char c : key)
    if (c != ']') dotted += c == '[' ? '.' : c;
  return place.ends_with(" " + dotted) ? place : place + ": " + key;
}

}  // namespace

Table::Table(const toml::table& table, std::string file, std::string path, nlohmann::json& record)
    : table_(&table), file_(std::move(file)), path_(std::move(path)), record_(&record) {
  if (record_->is_null()) *record_ = nlohmann::json::object();
}

std::string Table::place_at(const toml::source_region& where, const std::string& key) const {
  const std::string name = key.empty() ? path_ : path_of(key);
  if (given(where)) return fmt::format("{}: {}", file_, place_given(*where.path, name));
  const std::string line =
      where.begin.line == 0 || name.empty() ? "" : fmt::format(":{}:{}", where.begin.line, where.begin.column);
  std::string with;  // of a whole table: what of it does not stand there
  for (const auto& [_, value] : *table_)
    if (key.empty() && given(value.source())) with += (with.empty() ? " (with " : ", ") + *value.source().path;
  return file_ + line + (with.empty() ? "" : with + ")") + (name.empty() ? "" : ": " + name);
}

std::string Table::place(const std::string& key) const {
  const toml::node* n = key.empty() ? nullptr : table_->get(key);
  return place_at(n ? n->source() : table_->source(), key);
}

void Table::fail_at(const toml::source_region& where, const std::string& key, const std::string& message) const {
  throw InputError(place_at(where, key) + ": " + message);
}

void Table::fail(const std::string& key, const std::string& message) const {
  throw InputError(place(key) + ": " + message);
}

bool Table::has(const std::string& key) const { return table_->contains(key); }

const toml::node& Table::node(const std::string& key) {
  known_.insert(key);
  const toml::node* n = table_->get(key);
  if (n == nullptr) fail("", fmt::format("{} is missing", as_in_toml(key)));
  return *n;
}

double Table::quantity(const toml::node& value, const std::string& key, const Dimension& dimension,
                       const Range& range) const {
  Quantity read;
  const double& v = read.value;
  if (const auto* i = value.as_integer())
    read.value = static_cast<double>(i->get());
  else if (const auto* f = value.as_floating_point())
    read.value = f->get();
  else if (const auto* s = value.as_string()) {
    try {
      read = parse_quantity(s->get(), dimension);
    } catch (const std::invalid_argument& e) {
      const char* hint = key.ends_with("friction") ? " (friction is tan of the angle: 0.577 for 30 deg)" : "";
      fail_at(value.source(), key, fmt::format("\"{}\": {}{}", s->get(), e.what(), hint));
    }
  } else {
    fail_at(value.source(), key, fmt::format("expected a {}", dimension.name));
  }
  if (!std::isfinite(v)) fail_at(value.source(), key, "must be finite");
  if (v < range.low || (range.open_low && v == range.low))
    fail_at(value.source(), key,
            fmt::format("{}: must be {} {}", shown(value), range.open_low ? "above" : "at least",
                        bound_text(range.low, read, dimension)));
  if (v > range.high || (range.open_high && v == range.high))
    fail_at(value.source(), key,
            fmt::format("{}: must be {} {}", shown(value), range.open_high ? "below" : "at most",
                        bound_text(range.high, read, dimension)));
  return v;
}

void Table::declare(const std::string& key, const char* type, const Dimension& dimension, const Range& range,
                    const nlohmann::json& fallback, const std::vector<std::string>& words) const {
  const std::string_view t = type;
  const bool of_numbers =
      t == "number" || t == "list" || t == "free-list" || t == "pairs" || t == "points" || t == "matrix";
  check_key(path_of(key),
            {.path = {},
             .type = type,
             .unit = of_numbers ? dimension.name : "",
             .range = range_text(range),
             .fallback = {},
             .words = fmt::format("{}", fmt::join(words, "|")),
             .example = {},
             .meaning = {}},
            fallback);
}

double Table::number(const std::string& key, const Dimension& dimension, const Range& range) {
  declare(key, "number", dimension, range);
  const double v = quantity(node(key), key, dimension, range);
  (*record_)[key] = v;
  return v;
}

double Table::number_or(const std::string& key, double fallback, const Dimension& dimension, const Range& range) {
  declare(key, "number", dimension, range, std::isfinite(fallback) ? nlohmann::json(fallback) : nlohmann::json());
  known_.insert(key);
  if (has(key)) return number(key, dimension, range);
  if (std::isfinite(fallback)) (*record_)[key] = fallback;
  return fallback;
}

long Table::integer(const std::string& key, long low, long high) {
  declare(key, "integer", dimension::none, {static_cast<double>(low), static_cast<double>(high)});
  const auto* i = node(key).as_integer();
  if (i == nullptr) fail(key, "expected a whole number");
  const long v = static_cast<long>(i->get());
  if (v < low || v > high) fail(key, fmt::format("{}: must be from {} to {}", v, low, high));
  return (*record_)[key] = v, v;
}

long Table::integer_or(const std::string& key, long fallback, long low, long high) {
  declare(key, "integer", dimension::none, {static_cast<double>(low), static_cast<double>(high)}, fallback);
  known_.insert(key);
  if (has(key)) return integer(key, low, high);
  return (*record_)[key] = fallback, fallback;
}

bool Table::flag_or(const std::string& key, bool fallback) {
  declare(key, "flag", dimension::none, any, fallback);
  known_.insert(key);
  bool v = fallback;
  if (has(key)) {
    const auto* b = node(key).as_boolean();
    if (b == nullptr) fail(key, "expected true or false");
    v = b->get();
  }
  (*record_)[key] = v;
  return v;
}

std::string Table::word(const std::string& key) {
  const auto* s = node(key).as_string();
  if (s == nullptr) fail(key, "expected a text in quotes");
  (*record_)[key] = s->get();
  return s->get();
}

std::string Table::text(const std::string& key) {
  declare(key, "text", dimension::none, any);
  return word(key);
}

std::string Table::path(const std::string& key) {
  return (std::filesystem::path(file_).parent_path() / text(key)).string();
}

std::string Table::text_or(const std::string& key, const std::string& fallback) {
  declare(key, "text", dimension::none, any, fallback);
  known_.insert(key);
  if (has(key)) return word(key);
  (*record_)[key] = fallback;
  return fallback;
}

std::string Table::choice(const std::string& key, const std::vector<std::string>& words) {
  declare(key, "choice", dimension::none, any, {}, words);
  std::string chosen = word(key);
  if (std::find(words.begin(), words.end(), chosen) != words.end()) return chosen;
  const std::string near = closest(chosen, words);
  fail(key, fmt::format("\"{}\": {}", chosen,
                        near.empty() ? fmt::format("must be one of {}", fmt::join(words, ", "))
                                     : fmt::format("unknown (did you mean \"{}\"?)", near)));
}

std::string Table::choice_or(const std::string& key, const std::string& fallback,
                             const std::vector<std::string>& words) {
  declare(key, "choice", dimension::none, any, fallback, words);
  known_.insert(key);
  if (has(key)) return choice(key, words);
  (*record_)[key] = fallback;
  return fallback;
}

std::vector<double> Table::numbers(const std::string& key, std::size_t count, const Dimension& dimension) {
  declare(key, "list", dimension, any);
  const auto* a = node(key).as_array();
  if (a == nullptr || (count > 0 && a->size() != count))
    fail(key, fmt::format("expected a list of {} values{}", count, in_quotes(node(key))));
  std::vector<double> v;
  for (const auto& n : *a) v.push_back(quantity(n, key, dimension, any));
  (*record_)[key] = v;
  return v;
}

std::vector<double> Table::numbers_or(const std::string& key, std::vector<double> fallback,
                                      const Dimension& dimension) {
  declare(key, "list", dimension, any, fallback);
  known_.insert(key);
  if (has(key)) return numbers(key, fallback.size(), dimension);
  (*record_)[key] = fallback;
  return fallback;
}

std::vector<std::optional<double>> Table::free_numbers(const std::string& key, std::size_t count,
                                                       const Dimension& dimension) {
  declare(key, "free-list", dimension, any);
  const auto* a = node(key).as_array();
  if (a == nullptr || a->size() != count)
    fail(key, fmt::format("expected a list of {} values, each a {} or \"free\"{}", count, dimension.name,
                          in_quotes(node(key))));
  std::vector<std::optional<double>> v;
  auto recorded = nlohmann::json::array();
  for (const auto& n : *a) {
    if (const auto* s = n.as_string(); s != nullptr && s->get() == "free")
      v.emplace_back(), recorded.push_back("free");
    else
      v.emplace_back(quantity(n, key, dimension, any)), recorded.push_back(*v.back());
  }
  (*record_)[key] = recorded;
  return v;
}

std::vector<std::array<double, 2>> Table::pairs(const std::string& key, const Dimension& first) {
  declare(key, "pairs", first, any);
  const auto* rows = node(key).as_array();
  if (rows == nullptr || rows->empty()) fail(key, "expected a list of pairs such as [[0, 1], [1, 1]]");
  std::vector<std::array<double, 2>> v;
  for (const auto& n : *rows) {
    const auto* row = n.as_array();
    if (row == nullptr || row->size() != 2) fail(key, "expected a list of pairs such as [[0, 1], [1, 1]]");
    v.push_back({quantity((*row)[0], key, first, any), quantity((*row)[1], key, dimension::none, any)});
  }
  (*record_)[key] = v;
  return v;
}

std::vector<std::array<double, 3>> Table::points(const std::string& key, const Dimension& dimension) {
  declare(key, "points", dimension, any);
  const auto* rows = node(key).as_array();
  if (rows == nullptr) fail(key, "expected a list of points such as [[0, 0, 0], [1, 0, 0]]");
  std::vector<std::array<double, 3>> v;
  for (const auto& n : *rows) {
    const auto* row = n.as_array();
    if (row == nullptr || row->size() != 3) fail(key, "expected a list of points such as [[0, 0, 0], [1, 0, 0]]");
    v.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) v.back()[k] = quantity((*row)[k], key, dimension, any);
  }
  (*record_)[key] = v;
  return v;
}

std::vector<std::string> Table::texts_or_none(const std::string& key) {
  declare(key, "texts", dimension::none, any);
  known_.insert(key);
  std::vector<std::string> v;
  if (has(key)) {
    const auto* a = node(key).as_array();
    if (a == nullptr) fail(key, "expected a list of texts");
    for (const auto& n : *a) {
      if (!n.is_string()) fail(key, "expected a list of texts");
      v.push_back(n.as_string()->get());
    }
    (*record_)[key] = v;
  }
  return v;
}

bool Table::is_text(const std::string& key) const {
  const auto* n = table_->get(key);
  return n != nullptr && n->is_string();
}

std::size_t Table::length(const std::string& key) const {
  const auto* n = table_->get(key);
  return n != nullptr && n->is_array() ? n->as_array()->size() : 0;
}

std::array<std::array<double, 3>, 3> Table::matrix(const std::string& key, const Dimension& dimension) {
  declare(key, "matrix", dimension, any);
  const auto* rows = node(key).as_array();
  std::array<std::array<double, 3>, 3> m{};
  if (rows == nullptr || rows->size() != 3) fail(key, "expected three rows of three values");
  for (std::size_t i = 0; i < 3; ++i) {
    const auto* row = (*rows)[i].as_array();
    if (row == nullptr || row->size() != 3) fail(key, "expected three rows of three values");
    for (std::size_t j = 0; j < 3; ++j) m[i][j] = quantity((*row)[j], key, dimension, any);
  }
  (*record_)[key] = m;
  return m;
}

Table Table::table(const std::string& key) {
  declare(key, "table", dimension::none, any);
  const auto* t = node(key).as_table();
  if (t == nullptr) fail(key, "expected a table");
  return {*t, file_, path_of(key), (*record_)[key]};
}

std::optional<Table> Table::table_if(const std::string& key) {
  declare(key, "table", dimension::none, any);
  known_.insert(key);
  if (!has(key)) return std::nullopt;
  return table(key);
}

std::vector<Table> Table::tables(const std::string& key) {
  declare(key, "tables", dimension::none, any);
  known_.insert(key);
  std::vector<Table> found;
  if (!has(key)) return found;
  const auto* a = node(key).as_array();
  if (a == nullptr || !a->is_array_of_tables()) fail(key, fmt::format("expected [[{}]] tables", key));
  auto& record = (*record_)[key];
  record = nlohmann::json::array();
  for (std::size_t i = 0; i < a->size(); ++i) record.push_back(nlohmann::json::object());
  for (std::size_t i = 0; i < a->size(); ++i)
    found.emplace_back(*(*a)[i].as_table(), file_, fmt::format("{}[{}]", path_of(key), i), record[i]);
  return found;
}

std::vector<std::string> Table::table_names() const {
  std::vector<std::pair<toml::source_position, std::string>> named;
  for (const auto& [key, value] : *table_)
    if (value.is_table()) named.emplace_back(value.source().begin, std::string(key.str()));
  std::stable_sort(named.begin(), named.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (auto& n : named) names.push_back(n.second);
  return names;
}

void Table::finish() const {
  for (const auto& [key, value] : *table_) {
    const std::string name(key.str());
    if (known_.contains(name)) continue;
    const toml::source_region& where = given(value.source()) ? value.source() : key.source();
    if (row_of(path_of(name)) != nullptr)
      fail_at(where, name,
              fmt::format("nothing in this scene makes use of it ('grus keys {}' says what it is for)", name));
    const std::string near = closest(name, {known_.begin(), known_.end()});
    fail_at(where, name, near.empty() ? "unknown key" : fmt::format("unknown key (did you mean '{}'?)", near));
  }
}

}  // namespace grus::app
