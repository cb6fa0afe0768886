// SPDX-License-Identifier: LGPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <optional>
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

namespace {

/// Lines of two spheres in one place, if there are any: closer than a millionth of their radii.
std::optional<std::array<int, 2>> twins(const Packing& p, const std::vector<int>& line) {
  std::vector<std::size_t> order(p.spheres.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto x = [&](std::size_t k) { return p.spheres[k].position.x(); };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return x(a) < x(b); });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto& one = p.spheres[order[k]];
    for (std::size_t m = k + 1; m < order.size() && x(order[m]) - x(order[k]) < 1e-6 * one.radius; ++m)
      if ((p.spheres[order[m]].position - one.position).norm() < 1e-6 * one.radius)
        return std::array{std::min(line[order[k]], line[order[m]]), std::max(line[order[k]], line[order[m]])};
  }
  return {};
}

void check_packing(const Packing& p, const std::vector<int>& line, const std::string& path, bool walled) {
  if (p.box.minCoeff() > 0)
    for (std::size_t k = 0; k < p.spheres.size(); ++k) {
      const auto& s = p.spheres[k];
      if (2 * s.radius > p.box.minCoeff())
        throw InputError(
            fmt::format("{}:{}: a sphere of radius {:g} m does not fit into the box of {:g} x {:g} x {:g} m: "
                        "is the file in metres?",
                        path, line[k], s.radius, p.box.x(), p.box.y(), p.box.z()));
      if (walled && ((s.position.array() < 0).any() || (s.position.array() > p.box.array()).any()))
        throw InputError(fmt::format(
            "{}:{}: the centre {:g}, {:g}, {:g} m is outside of the box, 0 to {:g}, {:g}, {:g} m: "
            "is the file in metres?",
            path, line[k], s.position.x(), s.position.y(), s.position.z(), p.box.x(), p.box.y(), p.box.z()));
    }
  if (const auto two = twins(p, line))
    throw InputError(fmt::format("{}:{}: this sphere is where that of line {} is: leave one of them out", path,
                                 (*two)[1], (*two)[0]));
}

}  // namespace

Packing read_packing(const std::string& path, const Vec3& box, bool walled) {
  std::ifstream in(path);
  if (!in || !std::filesystem::is_regular_file(path)) throw InputError(fmt::format("{}: no such packing file", path));
  Packing p;
  p.box = box;
  std::vector<int> lines;
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
    lines.push_back(number);
  }
  if (p.spheres.empty()) throw InputError(fmt::format("{}: no spheres in the packing file", path));
  check_packing(p, lines, path, walled);
  return p;
}

}  // namespace grus::dem
