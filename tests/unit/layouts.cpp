// SPDX-License-Identifier: LGPL-3.0-or-later
// The number of a layout tells bytes of other fields, and nothing of what they hold.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#include <catch2/catch.hpp>
#endif

#include "dem/io/archive.hpp"

using namespace grus::dem;

namespace {

struct Row {
  double x = 0;
};
struct WiderRow {
  double x = 0;
  int n = 0;
};

template <class... Fields>
std::uint64_t number_of(const Fields&... field) {
  Layout layout;
  (field(layout), ...);
  return layout.number();
}

template <class T>
auto plain(const T& v) {
  return [&v](Layout& a) { a.plain(v); };
}
template <class T>
auto column(const std::vector<T>& v) {
  return [&v](Layout& a) { a.column(v); };
}

}  // namespace

TEST_CASE("another size, kind, order or number of fields is another layout") {
  const double x = 1, y = 2;
  const int n = 3;
  const std::vector<Row> rows(4), none;
  const std::vector<WiderRow> wider(4);
  const std::uint64_t here = number_of(plain(x), column(rows), plain(n));
  CHECK(number_of(plain(y), column(none), plain(n)) == here);  // whatever it holds
  CHECK(number_of(plain(x), column(wider), plain(n)) != here);
  CHECK(number_of(plain(n), column(rows), plain(x)) != here);
  CHECK(number_of(plain(x), column(rows), plain(x)) != here);
  CHECK(number_of(plain(x), column(rows)) != here);
  CHECK(number_of(plain(x), plain(Row{}), plain(n)) != here);
}

TEST_CASE("a state's layout counts the fields of a wall, and is that of any state") {
  State empty, walled;
  walled.boundary.walls.resize(1);
  walled.grains.motion.resize(5);
  Layout without, with;
  archive(without, std::as_const(empty)), archive(with, std::as_const(walled));
  CHECK(with.number() == layout_of_states());
  CHECK(without.number() != layout_of_states());
}
