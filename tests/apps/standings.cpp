// SPDX-License-Identifier: LGPL-3.0-or-later
// Where a macro run stands comes back whole, member by member, from what its checkpoint tells.
#include <algorithm>
#include <set>
#include <vector>

#include "apps/bvp/standing.hpp"
#include "fem/dynamics.hpp"
#include "fem/explicit_statics.hpp"
#include "tests/catch.hpp"

using namespace grus;

namespace {

/// Calls f on every number below v.
template <class T, class F>
void each_number(T& v, F&& f) {
  if constexpr (std::is_arithmetic_v<std::remove_const_t<T>> || std::is_enum_v<std::remove_const_t<T>>) {
    f(v);
  } else if constexpr (std::is_same_v<std::remove_const_t<T>, std::string>) {
  } else if constexpr (requires { v.begin(); }) {
    for (auto& member : v) each_number(member, f);
  } else {
    for_each_member(v, [&](auto& member) { each_number(member, f); });
  }
}

template <class T>
T filled() {
  T v{};
  double next = 1;
  each_number(v, [&](auto& number) {
    using N = std::remove_reference_t<decltype(number)>;
    number = std::is_enum_v<N> ? static_cast<N>(1) : static_cast<N>(next + 0.1), next += 1;  // no binary fraction
  });
  return v;
}

template <class T>
std::vector<double> numbers_of(const T& v) {
  std::vector<double> all;
  each_number(v, [&](const auto& number) { all.push_back(static_cast<double>(number)); });
  return all;
}

template <class T>
void comes_back(std::size_t numbers) {
  const T was = filled<T>();
  T is{};
  app::load(nlohmann::json::parse(app::save(was).dump()), is);
  CHECK(numbers_of(was).size() == numbers);
  CHECK(numbers_of(is) == numbers_of(was));
  nlohmann::json more = app::save(was), less = more;
  more.push_back("0x1p+0"), less.erase(less.size() - 1);
  CHECK_THROWS_AS(app::load(more, is), dem::InputError);
  CHECK_THROWS_AS(app::load(less, is), nlohmann::json::exception);
}

}  // namespace

TEST_CASE("every number of where a run stands comes back, exactly") {
  comes_back<fem::StaticsStart>(15);
  comes_back<fem::DynamicsReport>(12);
  comes_back<fem::ExplicitStaticsReport>(22);
}

TEST_CASE("a run goes on from all that its last increment says") {
  const fem::StaticsStart start = app::start_after(filled<fem::IncrementReport>());
  const std::vector<double> numbers = numbers_of(start);
  CHECK(std::count(numbers.begin(), numbers.end(), 0.0) == 0);
  CHECK(std::set<double>(numbers.begin(), numbers.end()).size() == numbers.size());
}

TEST_CASE("a number that is none is refused") {
  fem::DynamicsReport report = filled<fem::DynamicsReport>();
  nlohmann::json told = app::save(report);
  told.at(0) = "nan";
  CHECK_THROWS_AS(app::load(told, report), dem::InputError);
}
