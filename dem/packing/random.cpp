// SPDX-License-Identifier: LGPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/base/random.hpp"
#include "dem/packing/relaxation.hpp"

namespace grus::dem {
namespace {

/// Stages of growth: the share of the radii, and how long each may take.
constexpr int stages = 12;
constexpr double margin = 1e-4,
                 first = 0.75;  // spheres are grown a little too far, so that the final radii leave no overlap

/// Spheres of the radii that fill the box to the fraction (`radii`), thrown in at random.
Packing drawn(const Vec3& box, Container container, const RadiusDistribution& radius, double solid_fraction,
              std::size_t count, std::uint64_t seed, const std::vector<double>& reach, std::vector<double>& radii) {
  Packing p;
  p.box = box;
  const double target = solid_fraction * volume_of(container, box), most_scaled = 0.02;
  const double smallest = radius.kind == "constant" ? radius.mean : radius.min;
  const double least = 4 * pi / 3 * smallest * smallest * smallest;
  double solid = 0;
  for (std::uint64_t i = 0; count > 0 ? i < count : true; ++i) {
    const double r = draw_radius(radius, seed, i), v = 4 * pi / 3 * r * r * r;
    if (count == 0 && solid + 0.5 * v > target && i > 0) {
      if (std::abs(std::cbrt(target / solid) - 1) <= most_scaled || solid + 0.5 * least > target) break;
      if (i < 20'000'000) continue;  // of a wide grading one may be larger than all that is left to fill
    }
    if (i >= 20'000'000) throw InputError("more than 20 million grains would be needed; check box and radius");
    solid += v;
    p.spheres.push_back({{}, reach.empty() ? r : r * reach[p.spheres.size() % reach.size()]});
    for (int k = 0; k < 3; ++k)
      p.spheres.back().position[k] = random_uniform(seed, i, Purpose::position, static_cast<std::uint64_t>(k));
  }
  const double exact = std::cbrt(target / solid);
  if (std::abs(exact - 1) > most_scaled)
    throw InputError(fmt::format(
        "{} grains of this size fill {:.3f} of the box, not solid_fraction = {:g}; change count (or leave it out)",
        p.spheres.size(), solid / volume_of(container, box), solid_fraction));
  for (auto& s : p.spheres) {
    radii.push_back(s.radius * exact);
    if (2 * radii.back() >= box.minCoeff())
      throw InputError(fmt::format("a grain of radius {:.3g} m does not fit the box", radii.back()));
    if (container == Container::cylinder) {  // even over the disc
      const double away = 0.5 * std::sqrt(s.position[0]), angle = 2 * pi * s.position[1];
      s.position[0] = 0.5 + away * std::cos(angle);
      s.position[1] = 0.5 + away * std::sin(angle);
    }
    s.position = s.position.cwiseProduct(box);
  }
  return p;
}

}  // namespace

double volume_of(Container container, const Vec3& box) {
  return box.prod() * (container == Container::cylinder ? pi / 4 : 1);
}

Packing random_packing(const Vec3& box, const RadiusDistribution& radius, double solid_fraction, std::size_t count,
                       Container container, std::uint64_t seed, Team& team, const Watch& watch,
                       const std::vector<double>& reach) {
  std::vector<double> radii;
  Packing p = drawn(box, container, radius, solid_fraction, count, seed, reach, radii);
  if (container == Container::periodic) {
    Grains grains;
    for (std::size_t i = 0; i < radii.size(); ++i) grains.motion.push_back({}), grains.motion.back().radius = radii[i];
    Cell cell;
    cell.vectors = Mat3(box.asDiagonal());
    refuse_small_cell(grains, cell, 0.4 * radius.mean);
  }
  Relaxation relaxation(box, container, p.spheres, team);
  double steps = stages * 400 + 20000;
  double done = 0;
  auto grow = [&](double share, int iterations, double good) {
    for (std::size_t i = 0; i < radii.size(); ++i) p.spheres[i].radius = share * radii[i];
    const double worst = relaxation.run(
        iterations, good, [&](int it) { tell(watch, std::min(0.999, (done + it) / steps), "the sample was packed"); });
    done += iterations;
    return worst;
  };
  double worst = 0;
  for (int stage = 0; stage <= stages; ++stage)
    worst = grow(first + (1 + margin - first) * stage / stages, stage < stages ? 400 : 20000,
                 stage < stages ? 1e-2 : 0.5 * margin);
  // Places change hands, shaken by less each time: what experiments do by tapping.
  const auto cycles = static_cast<int>(std::clamp(6e8 / (2000.0 * static_cast<double>(radii.size())), 8.0, 60.0));
  if (worst > margin) steps += 2700.0 * cycles;
  for (int cycle = 0; worst > margin && cycle < cycles; ++cycle) {
    const std::uint64_t draw = seed + 1000003 * static_cast<std::uint64_t>(cycle + 1);
    if (reach.empty()) relaxation.swap(draw, 20 * radii.size());
    const double shake = 1 - static_cast<double>(cycle) / cycles;  // of the radius
    for (std::size_t i = 0; i < radii.size(); ++i) {
      Sphere& s = p.spheres[i];
      radii[i] = s.radius / (1 + margin);
      for (int k = 0; k < 3; ++k)
        s.position[k] +=
            shake * radii[i] * (2 * random_uniform(draw, i, Purpose::position, static_cast<std::uint64_t>(k)) - 1);
    }
    grow(0.8, 300, 1e-2), grow(0.95, 400, 1e-2);
    worst = grow(1 + margin, 2000, 0.5 * margin);
  }
  if (worst > margin) {
    double low = 0.9, high = 1;
    for (int k = 0; k < 7; ++k) {
      const double middle = 0.5 * (low + high);
      (grow(middle * (1 + margin), 2000, 0.5 * margin) > margin ? high : low) = middle;
    }
    throw InputError(
        fmt::format("{:g}: the densest random packing found of these grains in this box is {:.3f}; ask for less and "
                    "compress the sample, or use a larger box",
                    solid_fraction, std::floor(1000 * solid_fraction * low * low * low) / 1000));
  }
  for (std::size_t i = 0; i < radii.size(); ++i) p.spheres[i].radius = radii[i];
  p.worst_overlap = std::max(0.0, worst - margin);
  return p;
}

Packing random_packing(const Vec3& box, const RadiusDistribution& radius, double solid_fraction, std::size_t count,
                       bool periodic, std::uint64_t seed) {
  Team alone(1);
  return random_packing(box, radius, solid_fraction, count, periodic ? Container::periodic : Container::box, seed,
                        alone, {});
}

}  // namespace grus::dem
