// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/exact_sum.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace grus::fem {
namespace {

constexpr int lowest = -256, too_large = 128;  // exponents of 2: of the first digit's unit; of numbers
constexpr std::uint64_t low_half = 0xffffffffu;

/// True where one of three digits lies beyond 2^62, either way: a number adds less than 2^33 to it.
bool nearly_full(const std::int64_t* digit) {
  constexpr std::uint64_t half = std::uint64_t{1} << 62;
  std::uint64_t beyond = 0;
  for (int k = 0; k < 3; ++k) beyond |= static_cast<std::uint64_t>(digit[k]) + half;
  return beyond >> 63 != 0;
}

}  // namespace

void ExactSum::operator+=(double v) {
  const auto bits = std::bit_cast<std::uint64_t>(v);
  const int exponent = static_cast<int>(bits >> 52 & 0x7ff);
  if (exponent >= 1023 + too_large) {
    ++words_.back();
    return;
  }
  int at = exponent - 1075 - lowest;  // of the mantissa's last bit
  if (at <= -53) return;
  std::uint64_t mantissa = (bits & 0xfffffffffffffu) | 0x10000000000000u;
  if (at < 0) mantissa >>= -at, at = 0;
  const auto k = static_cast<std::size_t>(at / 32);
  const int shift = at % 32;
  const std::uint64_t low = (mantissa & low_half) << shift, high = (mantissa >> 32) << shift;
  const std::int64_t sign = bits >> 63 ? -1 : 1;
  if (nearly_full(&words_[k])) carry();
  words_[k] += sign * static_cast<std::int64_t>(low & low_half);
  words_[k + 1] += sign * static_cast<std::int64_t>((low >> 32) + (high & low_half));
  words_[k + 2] += sign * static_cast<std::int64_t>(high >> 32);
}

void ExactSum::operator+=(const ExactSum& other) {
  const Words theirs = other.words();
  carry();
  for (std::size_t k = 0; k < words_.size(); ++k) words_[k] += theirs[k];
  carry();
}

/// Brings every digit but the last into 0 .. 2^32 - 1.
void ExactSum::carry() {
  for (std::size_t k = 0; k + 1 < digits; ++k) {
    const std::int64_t over = words_[k] >> 32;
    words_[k] -= over * (std::int64_t{1} << 32), words_[k + 1] += over;
  }
}

ExactSum::Words ExactSum::words() const {
  ExactSum carried = *this;
  carried.carry();
  return carried.words_;
}

ExactSum ExactSum::of(const Words& words) {
  ExactSum sum;
  sum.words_ = words;
  return sum;
}

double ExactSum::value() const {
  Words w = words();
  if (w.back() != 0) return std::numeric_limits<double>::quiet_NaN();
  const bool negative = w[digits - 1] < 0;
  if (negative) {
    for (auto& digit : w) digit = -digit;
    w = of(w).words();
  }
  std::size_t top = digits;
  while (top > 0 && w[top - 1] == 0) --top;
  if (top == 0) return 0;
  // The leading 64 bits, the last of which also says that there is something below them: a double is rounded to
  // nearest.
  const auto digit = [&](std::size_t below) {
    return below < top ? static_cast<std::uint64_t>(w[top - 1 - below]) : std::uint64_t{0};
  };
  const std::uint64_t leading = digit(0) << 32 | digit(1);
  const int room = std::countl_zero(leading);  // below 32: the first digit is not 0
  std::uint64_t bits = leading << room | digit(2) >> (32 - room);
  bool more = (digit(2) << room & low_half) != 0;
  for (std::size_t k = 3; k < top; ++k) more = more || digit(k) != 0;
  if (more) bits |= 1;
  const double size = std::ldexp(static_cast<double>(bits), lowest + 32 * (static_cast<int>(top) - 2) - room);
  return negative ? -size : size;
}

}  // namespace grus::fem
