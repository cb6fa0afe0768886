// SPDX-License-Identifier: LGPL-3.0-or-later
// Loose grains, and all pairs of them that meet: what lists of near pairs are held against.
#pragma once

#include "dem/packing/packing.hpp"
#include "dem/shape/common_normal.hpp"
#include "dem/state/order.hpp"
#include "tests/helpers.hpp"

namespace grus::dem::test {

/// Loose grains in a cell that shears, or between walls of which one comes in; speed in m/s, rate in 1/s.
inline State loose(const Model& model, std::size_t grains, bool periodic, bool shapes, double speed, double rate,
                   Team& team) {
  State s;
  const double fraction = 0.45, size = std::cbrt(static_cast<double>(grains) * 1.225e-10 / fraction);
  for (const auto& sphere : random_packing(Vec3::Constant(size), {"truncated-normal", 3e-4, 5e-5, 1e-4, 4.5e-4},
                                           fraction, grains, periodic, 11)
                                .spheres) {
    PolyEllipsoid shape = PolyEllipsoid::sphere(sphere.radius);
    const std::size_t i = s.grains.size();
    if (shapes && i % 3 == 0) shape.plus.x() *= 0.6, shape.minus.y() *= 0.8;
    set_grain(s.grains, i,
              {.shape = shape,
               .position = sphere.position,
               .velocity = speed * (random_rotation(6, i) * Vec3(1, 0, 0)),
               .orientation = random_rotation(5, i),
               .density = 2650});
  }
  sort_in_space(s.grains);
  if (periodic)
    s.boundary.cell.vectors = size * Mat3::Identity();
  else
    add_box(s, size), s.boundary.walls.back().velocity.z() = -rate * size;
  prepare(model, s, team);
  if (periodic) {
    Mat3 gradient = Mat3::Zero();
    gradient.diagonal() = Vec3(-1, 0.6, -0.8), gradient(0, 1) = 0.8;
    set_cell_rate(s, rate * size * gradient);
  }
  return s;
}

inline bool listed(const Contacts& c, bool wall, std::size_t i, std::size_t j, std::array<std::int16_t, 3> image,
                   bool touching) {
  for (std::size_t k = wall ? c.begin[first_wall] : 0; k < (wall ? c.size() : c.begin[first_wall]); ++k)
    if (c.pair[k].a == i && c.pair[k].b == j && c.pair[k].image == image) return !touching || c.contact.touching(k);
  return false;
}

/// Vector from i to the nearest image of j, and that image, which is the only near one: no cell here is that small.
inline std::pair<Vec3, std::array<std::int16_t, 3>> nearest(const Mat3& cell, const Vec3& i, const Vec3& j) {
  Vec3 r = j - i;
  std::array<std::int16_t, 3> image{};
  if (cell(0, 0) == 0) return {r, image};
  const Vec3 f = cell.inverse() * r;
  for (int k = 0; k < 3; ++k) image[static_cast<std::size_t>(k)] = static_cast<std::int16_t>(-std::lround(f[k]));
  r += cell * Vec3(image[0], image[1], image[2]);
  return {r, image};
}

/// Pairs that overlap by more than `least`, by looking at all, and how many of them do not touch on the list.
struct Meeting {
  std::size_t pairs = 0, missed = 0;
};

inline Meeting all_pairs(const State& s, double least) {
  const Grains& g = s.grains;
  Meeting m;
  for (std::size_t i = 0; i < g.size(); ++i) {
    for (std::size_t j = i + 1; j < g.size(); ++j) {
      const auto [r, image] = nearest(s.boundary.cell.vectors, g.motion[i].position, g.motion[j].position);
      double overlap = g.motion[i].radius + g.motion[j].radius - r.norm();
      if (overlap > least && !(is_sphere(g, i) && is_sphere(g, j))) {
        const Frame a = frame_of(g, i), b = frame_of(g, j);
        const Vec3 apart = b.origin - g.motion[j].position + r + g.motion[i].position - a.origin;
        overlap = cold_common_normal({g.shape[i], g.shape[j], a.axes.transpose() * b.axes, a.axes.transpose() * apart})
                      .overlap;
      }
      if (overlap > least) ++m.pairs, m.missed += !listed(s.contacts, false, i, j, image, true);
    }
    for (std::size_t w = 0; w < s.boundary.walls.size(); ++w) {
      const Wall& wall = s.boundary.walls[w];
      const Vec3 inward = wall.facing();
      const Vec3 tip = is_sphere(g, i) ? Vec3(-g.motion[i].radius * inward) : surface_arm(g, i, -inward);
      if (inward.dot(g.motion[i].position + tip - wall.point) < -least)
        ++m.pairs, m.missed += !listed(s.contacts, true, i, w, {}, true);
    }
  }
  return m;
}

}  // namespace grus::dem::test
