// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <stdexcept>

namespace grus::app {
namespace {

struct Unit {
  double factor;
  Dimension dimension;
};

const std::map<std::string, Unit>& plain_units() {
  static const std::map<std::string, Unit> units{
      {"m", {1, dimension::length}},
      {"g", {1e-3, dimension::mass}},
      {"s", {1, dimension::time}},
      {"min", {60, dimension::time}},
      {"h", {3600, dimension::time}},
      {"N", {1, dimension::force}},
      {"Pa", {1, dimension::pressure}},
      {"bar", {1e5, dimension::pressure}},
      {"psi", {6894.757293168361, dimension::pressure}},  // lbf/in^2 = 0.45359237 * 9.80665 / 0.0254^2
      {"ksi", {6894757.293168361, dimension::pressure}},
      {"Hz", {1, dimension::rate}},
      {"J", {1, {2, 1, -2, "energy", "J"}}},
      {"rad", {1, dimension::angle}},
      {"deg", {0.017453292519943295, dimension::angle}},
      {"%", {0.01, dimension::none}},
      {"1", {1, dimension::none}}};
  return units;
}

std::vector<std::string> unit_names() {
  std::vector<std::string> names;
  for (const auto& [name, unit] : plain_units()) names.push_back(name);
  for (const char* name : {"mm", "um", "nm",  "cm",  "km",  "kg",  "mg", "ms", "us",  "ns", "kN",
                           "mN", "MN", "kPa", "MPa", "GPa", "TPa", "kJ", "mJ", "kHz", "MHz"})
    names.emplace_back(name);
  return names;
}

/// The micro sign and the Greek letter are a "u".
std::string with_plain_micro(const std::string& name) {
  for (const char* micro : {"\u00b5", "\u03bc"})
    if (name.starts_with(micro)) return fmt::format("u{}", name.substr(std::strlen(micro)));
  return name;
}

Unit unit_of(const std::string& written) {
  const std::string name = with_plain_micro(written);
  const auto& units = plain_units();
  if (auto it = units.find(name); it != units.end()) return it->second;
  static const std::map<char, double> prefixes{{'n', 1e-9}, {'u', 1e-6}, {'m', 1e-3}, {'c', 1e-2},
                                               {'k', 1e3},  {'M', 1e6},  {'G', 1e9},  {'T', 1e12}};
  if (name.size() > 1 && prefixes.contains(name[0])) {
    const std::string base = name.substr(1);
    if (base == "m" || base == "g" || base == "s" || base == "N" || base == "Pa" || base == "J" || base == "Hz") {
      const Unit u = units.at(base);
      return {prefixes.at(name[0]) * u.factor, u.dimension};
    }
  }
  const bool word = std::isalpha(static_cast<unsigned char>(name[0]));  // a sign is near to each unit of one letter
  const std::string near = word ? closest(name, unit_names()) : "";
  throw std::invalid_argument(
      fmt::format("unknown unit '{}'{}", name, near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
}

/// What people write for powers, products and degrees: "m²", "N·m", "30°".
std::string with_plain_signs(std::string text) {
  for (const auto& [sign, plain] : {std::pair{"\u00b2", "^2"}, {"\u00b3", "^3"}, {"\u00b7", " "}, {"\u00b0", "deg"}})
    for (std::size_t at; (at = text.find(sign)) != std::string::npos;) text.replace(at, std::strlen(sign), plain);
  return text;
}

/// Where the power of a factor begins that has no '^': "m3", "m-3"; its end where there is none.
std::size_t bare_power(const std::string& factor) {
  std::size_t at = factor.size();
  while (at > 0 && std::isdigit(static_cast<unsigned char>(factor[at - 1]))) --at;
  if (at > 0 && at < factor.size() && factor[at - 1] == '-') --at;
  return at > 0 ? at : factor.size();
}

/// kg/m^3, kg/m3, MPa m^0.5, N/(m s) without brackets: factors joined by space, '*' or '/'.
Unit parse_unit(const std::string& written) {
  const std::string text = with_plain_signs(written);
  Unit product{1, {0, 0, 0, ""}};
  double sign = 1;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == ' ' || c == '*') {
      ++i;
    } else if (c == '/') {
      sign = -1;
      ++i;
    } else {
      std::size_t end = i;
      while (end < text.size() && !std::strchr(" */^", text[end])) ++end;
      const std::string factor = text.substr(i, end - i), base = factor.substr(0, bare_power(factor));
      const Unit u = unit_of(base);
      double power = base.size() < factor.size() ? std::stod(factor.substr(base.size())) : 1;
      if (end < text.size() && text[end] == '^') {
        const auto [rest, fault] = std::from_chars(text.data() + end + 1, text.data() + text.size(), power);
        if (fault != std::errc())
          throw std::invalid_argument(fmt::format("expected a power after '^' in the unit '{}'", text));
        end = static_cast<std::size_t>(rest - text.data());
      }
      power *= sign;
      sign = 1;
      product.factor *= std::pow(u.factor, power);
      product.dimension.metre += power * u.dimension.metre;
      product.dimension.kilogram += power * u.dimension.kilogram;
      product.dimension.second += power * u.dimension.second;
      product.dimension.radian += power * u.dimension.radian;
      i = end;
    }
  }
  return product;
}

std::string lower(std::string s) {
  std::transform(s.begin(), s.end(), s.begin(), [](unsigned char c) { return std::tolower(c); });
  return s;
}

std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
      diagonal = above;
    }
  }
  return row[b.size()];
}

}  // namespace

std::string closest(const std::string& word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const auto& c : candidates)  // half a word is nearer than any misspelling
    if (word.size() >= 3 && c.size() > word.size() && lower(c).starts_with(lower(word))) return c;
  for (const auto& c : candidates) {
    const std::size_t d = lower(c) == lower(word) ? 0 : distance(lower(word), lower(c));
    if (d < least) least = d, best = c;
  }
  return best;
}

Quantity parse_quantity(const std::string& text, const Dimension& expected) {
  std::size_t used = 0;
  double value = 0;
  const char* begin = text.data() + std::min(text.find_first_not_of(' '), text.size());
  if (*begin == '+' && begin[1] != '-') ++begin;
  const auto [end, fault] =
      std::from_chars(begin, text.data() + text.size(), value);  // decimal: no hexadecimal, whatever the locale
  if (fault != std::errc())
    throw std::invalid_argument(fmt::format("expected a {}, a number with or without a unit", expected.name));
  used = static_cast<std::size_t>(end - text.data());
  while (used < text.size() && text[used] == ' ') ++used;
  if (used == text.size()) return {value};
  if (text[used] == ',') throw std::invalid_argument("write a decimal point, not a comma");
  const Unit unit = parse_unit(text.substr(used));
  const auto& d = unit.dimension;
  auto differs = [](double a, double b) { return std::abs(a - b) > 1e-9; };
  if (differs(d.metre, expected.metre) || differs(d.kilogram, expected.kilogram) || differs(d.second, expected.second))
    throw std::invalid_argument(fmt::format("unit '{}' is not that of a {}", text.substr(used), expected.name));
  const bool pure = expected.metre == 0 && expected.kilogram == 0 && expected.second == 0;
  if (pure && differs(d.radian, expected.radian))  // spins may be in rad/s or 1/s
    throw std::invalid_argument(expected.radian == 0 ? "is an angle where a number is expected"
                                                     : fmt::format("'{}' is no unit of an angle", text.substr(used)));
  return {value * unit.factor, text.substr(used), unit.factor};
}

std::string bound_text(double bound, const Quantity& of, const Dimension& dimension) {
  if (bound == 0) return "0";
  if (!of.unit.empty()) return fmt::format("{:g} {}", bound / of.factor, of.unit);
  const char* space = *dimension.unit ? " " : "";
  const std::string si = fmt::format("{:g}{}{}", bound, space, dimension.unit);
  return dimension.radian == 1 ? fmt::format("{} ({:g} deg)", si, bound / unit_of("deg").factor) : si;
}

}  // namespace grus::app
