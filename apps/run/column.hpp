// SPDX-License-Identifier: LGPL-3.0-or-later
// A column of history.csv is a value: name, unit, what it is, when it is there, and how a row has it. One table gives
// names, rows and the page of columns (docs/make_site.py).
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>
#include <vector>

namespace grus::app {

/// A column, or a family of them (components, walls, grains), whose k-th is asked for by its number.
template <class Row>
struct Column {
  std::string name;  // with its unit
  const char* unit;  // "" of a plain number
  const char* doc;
  double (*of)(const Row& row, std::size_t k);
  std::size_t k = 0;
};

/// A row of a table. `when`: whether the column is there; `names`: of a family, for "{}" in its name.
template <class Row, class Told>
struct ColumnEntry {
  const char *name, *unit, *doc;
  bool (*when)(const Told& told);
  double (*of)(const Row& row, std::size_t k);
  std::vector<std::string> (*names)(const Told& told) = nullptr;
};

/// Those that are there, in the order of the table.
template <class Row, class Told>
std::vector<Column<Row>> columns_of(const std::vector<ColumnEntry<Row, Told>>& table, const Told& told) {
  std::vector<Column<Row>> columns;
  for (const auto& e : table) {
    if (!e.when(told)) continue;
    if (!e.names) {
      columns.push_back({e.name, e.unit, e.doc, e.of});
      continue;
    }
    const std::vector<std::string> names = e.names(told);
    for (std::size_t k = 0; k < names.size(); ++k)
      columns.push_back({fmt::format(fmt::runtime(e.name), names[k]), e.unit, e.doc, e.of, k});
  }
  return columns;
}

template <class Row>
std::vector<std::string> names_of(const std::vector<Column<Row>>& columns) {
  std::vector<std::string> names;
  for (const auto& c : columns) names.push_back(c.name);
  return names;
}

/// The column that `of` reads, in a list; none where it is not there.
template <class Row>
std::optional<std::size_t> find_column(const std::vector<Column<Row>>& columns,
                                       double (*of)(const Row& row, std::size_t k)) {
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c].of == of) return c;
  return {};
}

/// The values of a row, one for each column.
template <class Row>
std::vector<double> values_of(const std::vector<Column<Row>>& columns, const Row& row) {
  std::vector<double> values;
  for (const auto& c : columns) values.push_back(c.of(row, c.k));
  return values;
}

}  // namespace grus::app
