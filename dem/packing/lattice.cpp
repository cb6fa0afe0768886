// SPDX-License-Identifier: LGPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <sstream>

#include "dem/base/error.hpp"
#include "dem/base/text_file.hpp"
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

constexpr double deepest = 0.5;  // overlap of two spheres, and with a wall, by radius: no sample begins with so much

/// Lines of two spheres that lie in one another, if there are any; in a periodic box by their images too.
std::optional<std::array<int, 2>> merged(const Packing& p, const std::vector<int>& line, bool periodic) {
  const std::size_t n = p.spheres.size();
  std::vector<double> x;
  double largest = 0;
  for (const auto& s : p.spheres) {
    largest = std::max(largest, s.radius);
    x.push_back(s.position.x() - (periodic ? p.box.x() * std::floor(s.position.x() / p.box.x()) : 0));
  }
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return x[a] < x[b]; });
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t m = k + 1; m < (periodic ? k + n : n); ++m) {
      const std::size_t i = order[k], j = order[m % n];
      const auto &one = p.spheres[i], &other = p.spheres[j];
      if (x[j] + (m < n ? 0 : p.box.x()) - x[i] > one.radius + largest) break;
      Vec3 between = other.position - one.position;
      if (periodic) between.array() -= p.box.array() * (between.array() / p.box.array()).round();
      if (one.radius + other.radius - between.norm() > deepest * std::min(one.radius, other.radius))
        return std::array{std::min(line[i], line[j]), std::max(line[i], line[j])};
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
      if (const double near = std::min(s.position.minCoeff(), (p.box - s.position).minCoeff());
          walled && near < (1 - deepest) * s.radius)
        throw InputError(
            fmt::format("{}:{}: this sphere of radius {:g} m sticks out of the box: its centre is {:g} m from a wall; "
                        "move it in or "
                        "make the box larger",
                        path, line[k], s.radius, near));
    }
  if (const auto two = merged(p, line, !walled && p.box.minCoeff() > 0))
    throw InputError(fmt::format("{}:{}: this sphere is where that of line {} is{}: leave one of them out", path,
                                 (*two)[1], (*two)[0], walled ? "" : ", or an image of it"));
}

}  // namespace

Packing read_packing(const std::string& path, const Vec3& box, bool walled) {
  const auto in = open_text(path);
  if (!in) throw InputError(fmt::format("{}: no such packing file", path));
  Packing p;
  p.box = box;
  std::vector<int> lines;
  std::string line;
  for (int number = 1; std::getline(*in, line); ++number) {
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
