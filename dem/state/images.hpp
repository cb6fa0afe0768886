// SPDX-License-Identifier: LGPL-3.0-or-later
// Where a periodic image lies, and how fast it goes there.
#pragma once

#include <array>
#include <cstdint>

#include "dem/base/tensor.hpp"

namespace grus::dem {

/// The columns of `m`, each as often as the image's number says: of a cell's vectors its place (m), of their rate its
/// speed (m/s). Nothing for the cell itself.
inline Vec3 at_image(const Mat3& m, const std::array<std::int16_t, 3>& image) {
  const double x = image[0], y = image[1], z = image[2];
  return {m(0, 0) * x + (m(0, 1) * y + m(0, 2) * z), m(1, 0) * x + (m(1, 1) * y + m(1, 2) * z),
          m(2, 0) * x + (m(2, 1) * y + m(2, 2) * z)};
}

}  // namespace grus::dem
