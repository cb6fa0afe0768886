// SPDX-License-Identifier: LGPL-3.0-or-later
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "dem/base/error.hpp"
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

Packing read_packing(const std::string& path, const Vec3& box) {
  std::ifstream in(path);
  if (!in || !std::filesystem::is_regular_file(path)) throw InputError(fmt::format("{}: no such packing file", path));
  Packing p;
  p.box = box;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line = line.substr(0, line.find('#'));
    std::istringstream text(line);
    double x, y, z, r;
    std::string rest;
    if (!(text >> x)) {
      text.clear();
      if (text >> rest) throw InputError(fmt::format("{}:{}: expected numbers x y z r", path, number));
      continue;  // blank
    }
    if (!(text >> y >> z >> r) || (text >> rest) || !(r > 0) || !std::isfinite(x + y + z + r))
      throw InputError(fmt::format("{}:{}: expected x y z r with r > 0", path, number));
    p.spheres.push_back({{x, y, z}, r});
  }
  if (p.spheres.empty()) throw InputError(fmt::format("{}: no spheres in the packing file", path));
  return p;
}

}  // namespace grus::dem
