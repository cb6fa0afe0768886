// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/pressing.hpp"

#include <algorithm>

#include "dem/base/random.hpp"
#include "dem/packing/relaxation.hpp"

namespace grus::dem {
namespace {

constexpr int stages = 12, halvings = 7, stage_steps = 400, fit_steps = 2000, most_fits = 6;
constexpr double pushed = 1.02;   // of the share that is reached: overlaps are what makes places change
constexpr double finest = 5e-4;   // the least step of the share
constexpr double loosest = 0.75;  // of the share that would fill 0.64

}  // namespace

double pressing_steps(int cycles) {
  return stages * stage_steps + halvings * fit_steps + cycles * (1300.0 + 2 * fit_steps);
}

Pressed press(const Vec3& box, Container container, std::vector<Sphere> spheres, double share, std::uint64_t seed,
              const Course& course, Team& team) {
  std::vector<double> radii;
  for (const Sphere& s : spheres) radii.push_back(s.radius);
  Relaxation relaxation(box, container, spheres, team);
  double done = 0;
  const auto grow = [&](double to, int iterations, double good) {
    for (std::size_t i = 0; i < radii.size(); ++i) spheres[i].radius = to * radii[i];
    const double worst = relaxation.run(iterations, good, [&](int it) { course.watch(done + it); });
    done += iterations;
    return worst;
  };
  Pressed best{{}, 0};
  const auto fits = [&](double to) {
    if (grow(to * (1 + course.margin), fit_steps, 0.5 * course.margin) > course.margin) return false;
    best = {spheres, to};
    for (std::size_t i = 0; i < radii.size(); ++i) best.spheres[i].radius = radii[i];
    return true;
  };
  for (int stage = 0; stage <= stages; ++stage)
    grow(share * (loosest + (1 - loosest) * stage / stages), stage_steps, 1e-2);
  double low = loosest * share, high = 1.05 * share;
  for (int k = 0; k < halvings || best.share == 0; ++k) {
    const double middle = 0.5 * (low + high);
    (fits(middle) ? low : high) = middle;
    if (best.share == 0 && k >= halvings) high = low, low *= 0.5;  // looser than that
  }
  for (int cycle = 0; cycle < course.cycles && best.share < course.enough; ++cycle) {
    const std::uint64_t draw = seed + 1000003 * static_cast<std::uint64_t>(cycle + 1);
    const double from = best.share, over = pushed * from;
    grow(over, 300, 1e-2);
    if (course.swaps) relaxation.swap(draw, 20 * radii.size());
    const double shake = from * (1 - static_cast<double>(cycle) / course.cycles);
    for (std::size_t i = 0; i < radii.size(); ++i) {
      radii[i] = spheres[i].radius / over;
      for (int k = 0; k < 3; ++k)
        spheres[i].position[k] +=
            shake * radii[i] * (2 * random_uniform(draw, i, Purpose::position, static_cast<std::uint64_t>(k)) - 1);
    }
    grow(0.8 * from, 300, 1e-2), grow(0.95 * from, 400, 1e-2), grow(over, 300, 1e-2);
    double step = finest;
    for (int k = 0; k < most_fits && fits(best.share * (1 + step)); ++k) step *= 2;
  }
  return best;
}

}  // namespace grus::dem
