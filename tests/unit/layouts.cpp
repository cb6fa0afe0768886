// SPDX-License-Identifier: LGPL-3.0-or-later
// The number of a layout tells bytes of other fields, and nothing of what they hold.
#include "dem/io/archive.hpp"
#include "tests/catch.hpp"

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

template <class T>
std::uint64_t walked(const T& v) {
  Layout layout;
  walk(layout, v);
  return layout.number();
}

TEST_CASE("a row's numbers count, whatever is there") {
  struct Whole {
    double x = 0;
    std::uint64_t n = 0;
  };
  struct Halves {
    double x = 0;
    double n = 0;
  };
  struct Turned {
    std::uint64_t n = 0;
    double x = 0;
  };
  CHECK(walked(std::vector<Whole>(3)) == walked(std::vector<Whole>{}));
  CHECK(walked(std::vector<Whole>{}) != walked(std::vector<Halves>{}));
  CHECK(walked(std::vector<Whole>{}) != walked(std::vector<Turned>{}));
  CHECK(walked(std::vector<WiderRow>{}) != walked(std::vector<Row>{}));  // of rows with bytes in between, too
  CHECK(walked(std::optional<Whole>{}) == walked(std::optional<Whole>(Whole{})));
  CHECK(walked(std::optional<Whole>{}) != walked(std::optional<Halves>{}));
}

TEST_CASE("a variant's layout is that of all its kinds, whichever is there") {
  struct Other {
    double y = 0;
  };
  using Kinds = std::variant<Row, WiderRow>;
  CHECK(walked(Kinds{Row{}}) == walked(Kinds{WiderRow{}}));
  CHECK(walked(Kinds{}) != walked(std::variant<WiderRow, Row>{}));
  CHECK(walked(Kinds{}) != walked(std::variant<Row, WiderRow, Other>{}));
  CHECK(walked(Kinds{}) != walked(std::variant<Row>{}));
}

TEST_CASE("a state's layout is that of any state") {
  State walled;
  walled.boundary.walls.resize(2), walled.boundary.walls[1].shape = RollerWall{};
  walled.grains.motion.resize(5);
  walled.grains.hulls = std::make_shared<HullStore>();
  CHECK(walked(State{}) == walked(walled));
  CHECK(walked(State{}) == layout_of_states());
}
