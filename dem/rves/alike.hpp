// SPDX-License-Identifier: LGPL-3.0-or-later
// Increments that differ by the macro solver's round-off only are the same.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <span>

#include "dem/base/tensor.hpp"

namespace grus::dem {

/// Increments are taken to 2^-34 (6e-11 of strain, 0.1 Pa).
inline Mat3 snapped(std::span<const double> f) {
  Mat3 m;
  for (int k = 0; k < 9; ++k) m(k / 3, k % 3) = std::nearbyint(f[static_cast<std::size_t>(k)] * 0x1p34) * 0x1p-34;
  return m;
}

/// Increments that differ by the macro solver's round-off are one: a point takes that of the first one within 2^-30 or
/// so (1e-9 of strain). Grains are chaotic: without this the last bit would tell all points of a homogeneous block
/// apart.
class Alike {
public:
  Mat3 operator()(const Mat3& f) {
    // Three grids, shifted: neighbours across a border of one share a cell of another.
    for (std::size_t g = 0; g < 3; ++g)
      if (const auto at = seen_[g].find(key(f, g)); at != seen_[g].end()) return at->second;
    for (std::size_t g = 0; g < 3; ++g) seen_[g].emplace(key(f, g), f);
    return f;
  }

private:
  static std::array<double, 9> key(const Mat3& f, std::size_t grid) {
    std::array<double, 9> cell;
    for (int k = 0; k < 9; ++k)
      cell[static_cast<std::size_t>(k)] = std::floor(f(k / 3, k % 3) * 0x1p30 + static_cast<double>(grid) / 3 + 0.17);
    return cell;
  }
  std::array<std::map<std::array<double, 9>, Mat3>, 3> seen_;
};

}  // namespace grus::dem
