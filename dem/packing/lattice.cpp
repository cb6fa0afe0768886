// SPDX-License-Identifier: LGPL-3.0-or-later
#include <cmath>

#include "dem/packing/packing.hpp"

namespace grus::dem {

Packing simple_cubic(double r, const std::array<int, 3>& layers) {
  Packing p;
  p.box = 2 * r * Vec3(layers[0], layers[1], layers[2]);
  for (int z = 0; z < layers[2]; ++z)
    for (int y = 0; y < layers[1]; ++y)
      for (int x = 0; x < layers[0]; ++x) p.spheres.push_back({r * Vec3(2 * x + 1, 2 * y + 1, 2 * z + 1), r});
  return p;
}

Packing hexagonal_close(double r, const std::array<int, 3>& layers) {
  Packing p;
  const double row = std::sqrt(3.0) * r, height = std::sqrt(8.0 / 3) * r, shift = r / std::sqrt(3.0);
  for (int z = 0; z < layers[2]; ++z)
    for (int y = 0; y < layers[1]; ++y)
      for (int x = 0; x < layers[0]; ++x) {
        const double offset = (y + z) % 2;  // rows and layers alternate by a radius
        p.spheres.push_back({Vec3(r * (1 + 2 * x + offset), r + row * y + shift * (z % 2), r + height * z), r});
      }
  for (const auto& s : p.spheres) p.box = p.box.cwiseMax(s.position + Vec3::Constant(r));
  return p;
}

}  // namespace grus::dem
