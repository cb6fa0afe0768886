// SPDX-License-Identifier: LGPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/base/random.hpp"
#include "dem/packing/pressing.hpp"
#include "dem/packing/relaxation.hpp"

namespace grus::dem {
namespace {

/// Stages of growth: the share of the radii, and how long each may take.
constexpr int stages = 12;
constexpr double margin = 1e-4,
                 first = 0.75;  // spheres are grown a little too far, so that the final radii leave no overlap

constexpr double typical = 0.64;  // of equal spheres, far from walls

/// Radii are scaled by no more than this to fill the fraction; where more is needed the draw is another one.
constexpr double most_scaled = 0.02;

/// Spheres as drawn, thrown in at random, and the part of the box that is solid in them.
struct Drawn {
  std::vector<Sphere> spheres;
  double fraction;
  double scale(double solid_fraction) const { return std::cbrt(solid_fraction / fraction); }
};

Drawn draw_spheres(const Vec3& box, Container container, const RadiusDistribution& radius, double solid_fraction,
                   std::size_t count, std::uint64_t seed, const std::vector<double>& reach) {
  Drawn d;
  const double target = solid_fraction * volume_of(container, box);
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
    d.spheres.push_back({{}, reach.empty() ? r : r * reach[d.spheres.size() % reach.size()]});
    Sphere& s = d.spheres.back();
    for (int k = 0; k < 3; ++k)
      s.position[k] = random_uniform(seed, i, Purpose::position, static_cast<std::uint64_t>(k));
    if (container == Container::cylinder) {  // even over the disc
      const double away = 0.5 * std::sqrt(s.position[0]), angle = 2 * pi * s.position[1];
      s.position[0] = 0.5 + away * std::cos(angle);
      s.position[1] = 0.5 + away * std::sin(angle);
    }
    s.position = s.position.cwiseProduct(box);
  }
  d.fraction = solid / volume_of(container, box);
  return d;
}

/// Refuses spheres that the box cannot hold.
void refuse_large(const std::vector<Sphere>& spheres, double scale, const Vec3& box, Container container, double mean) {
  Grains grains;
  for (const Sphere& s : spheres) {
    grains.motion.push_back({}), grains.motion.back().radius = s.radius * scale;
    if (2 * s.radius * scale >= box.minCoeff())
      throw InputError(fmt::format("a grain of radius {:.3g} m does not fit the box", s.radius * scale));
  }
  const Cell cell = cell_of(container, box, 0);
  refuse_small_cell(grains, cell, 0.4 * mean);
}

/// Cycles of shaking that so many spheres get.
int shakes(std::size_t spheres) {
  return static_cast<int>(std::clamp(6e8 / (2000.0 * static_cast<double>(spheres)), 8.0, 60.0));
}

/// A packing of what the draw `asked` cannot be grown to, or a refusal that tells what can be had. The wish must not
/// enter where pressing gets to: it only says when to stop. `watch`: asked with the iterations so far and those in all.
Packing pressed_packing(const Vec3& box, const RadiusDistribution& radius, double solid_fraction, const Drawn& asked,
                        std::size_t count, Container container, std::uint64_t seed, Team& team,
                        const std::vector<double>& reach, const std::function<void(double, double)>& watch) {
  Drawn d = draw_spheres(box, container, radius, typical, count, seed, reach);
  refuse_large(d.spheres, d.scale(typical), box, container, radius.mean);
  const int cycles = shakes(d.spheres.size()), some = count == 0 ? std::max(4, cycles / 4) : 0;
  const double before = count == 0 ? pressing_steps(some) : 0, all = before + pressing_steps(cycles);
  const auto pressed = [&](int most, double enough, double begun) {
    const Course course{most, enough, reach.empty(), margin, [&](double it) { watch(begun + it, all); }};
    return press(box, container, d.spheres, d.scale(typical), seed, course, team);
  };
  const auto fraction_of = [&](double share) { return d.fraction * share * share * share; };
  if (count == 0) {  // as many grains as fill what they come to
    d = draw_spheres(box, container, radius, fraction_of(pressed(some, INFINITY, 0).share), 0, seed, reach);
    if (d.scale(solid_fraction) < 1 - most_scaled) d = asked;
  }
  Packing p{box, {}};
  const Pressed found = pressed(cycles, d.scale(solid_fraction), before);
  if (const double densest = fraction_of(found.share); densest < solid_fraction)
    throw InputError(fmt::format(
        "{:g}: the densest random packing found of these grains in this box is {:.3f}; ask for no more and compress "
        "the sample, or use a larger box",
        solid_fraction, std::floor(1000 * densest) / 1000));
  p.spheres = found.spheres;
  for (Sphere& s : p.spheres) s.radius *= d.scale(solid_fraction);
  refuse_large(p.spheres, 1, box, container, radius.mean);
  return p;
}

}  // namespace

Cell cell_of(Container container, const Vec3& box, double largest) {
  if (container == Container::periodic_xy) return walled_cell(box, largest);
  Cell cell;
  if (container == Container::periodic) cell.vectors = Mat3(box.asDiagonal());
  return cell;
}

double volume_of(Container container, const Vec3& box) {
  return box.prod() * (container == Container::cylinder ? pi / 4 : 1);
}

Packing random_packing(const Vec3& box, const RadiusDistribution& radius, double solid_fraction, std::size_t count,
                       Container container, std::uint64_t seed, Team& team, const Watch& watch,
                       const std::vector<double>& reach) {
  const Drawn first_draw = draw_spheres(box, container, radius, solid_fraction, count, seed, reach);
  const double scale = first_draw.scale(solid_fraction);
  if (std::abs(scale - 1) > most_scaled)
    throw InputError(fmt::format(
        "{} grains of this size fill {:.3f} of the box, not solid_fraction = {:g}; change count (or leave it out)",
        first_draw.spheres.size(), first_draw.fraction, solid_fraction));
  refuse_large(first_draw.spheres, scale, box, container, radius.mean);
  Packing p{box, first_draw.spheres};
  std::vector<double> radii;
  for (const Sphere& s : p.spheres) radii.push_back(s.radius * scale);
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
  const int cycles = shakes(radii.size());
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
  if (worst > margin)
    return pressed_packing(box, radius, solid_fraction, first_draw, count, container, seed, team, reach,
                           [&](double it, double more) {
                             tell(watch, std::min(0.999, (done + it) / (steps + more)), "the sample was packed");
                           });
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
