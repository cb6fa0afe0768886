// SPDX-License-Identifier: LGPL-3.0-or-later
// Counter-based random draws: a value depends on (seed, id, purpose, counter) and on nothing else,
// so a retried increment or another number of threads draws the same numbers.
#pragma once

#include "dem/base/tensor.hpp"

namespace grus::dem {

enum class Purpose : std::uint64_t {
  radius = 1,
  position = 2,
  orientation = 3,
  strength = 4,
  rotation = 5,
  turn = 6,
  lattice = 7
};

/// 64 mixed bits (splitmix64 finaliser, applied once for each key).
inline std::uint64_t random_bits(std::uint64_t seed, std::uint64_t id, Purpose purpose, std::uint64_t counter) {
  auto mix = [](std::uint64_t z) {
    z += 0x9e3779b97f4a7c15ULL;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  };
  return mix(mix(mix(mix(seed) ^ id) ^ static_cast<std::uint64_t>(purpose)) ^ counter);
}

/// Uniform in the open interval (0, 1).
inline double random_uniform(std::uint64_t seed, std::uint64_t id, Purpose purpose, std::uint64_t counter = 0) {
  return (static_cast<double>(random_bits(seed, id, purpose, counter) >> 11) + 0.5) * 0x1.0p-53;
}

/// Standard normal (Box and Muller).
inline double random_normal(std::uint64_t seed, std::uint64_t id, Purpose purpose, std::uint64_t counter = 0) {
  const double u = random_uniform(seed, id, purpose, 2 * counter);
  const double v = random_uniform(seed, id, purpose, 2 * counter + 1);
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * pi * v);
}

/// Uniformly distributed rotation (Shoemake).
inline Quat random_rotation(std::uint64_t seed, std::uint64_t id) {
  const double u = random_uniform(seed, id, Purpose::orientation, 0);
  const double a = 2 * pi * random_uniform(seed, id, Purpose::orientation, 1);
  const double b = 2 * pi * random_uniform(seed, id, Purpose::orientation, 2);
  const double s = std::sqrt(1 - u), c = std::sqrt(u);
  return Quat(c * std::cos(b), s * std::sin(a), s * std::cos(a), c * std::sin(b));
}

}  // namespace grus::dem
