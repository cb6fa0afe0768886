// SPDX-License-Identifier: LGPL-3.0-or-later
// Makers of samples: spheres only; positions and radii, seeded, the same on any number of threads.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/base/tensor.hpp"
#include "dem/base/watch.hpp"
#include "dem/state/boundary.hpp"

namespace grus::dem {

struct RadiusDistribution {
  std::string kind = "constant";              // "constant", "uniform", "truncated-normal", "log-normal", "sieve"
  double mean = 0, sd = 0, min = 0, max = 0;  // m, by number
  double median = 0, spread = 0;              // log-normal by mass: median (m), standard deviation of the logarithm
  std::vector<std::array<double, 2>> sieve =
      {};  // radius (m), mass passing (0 to 1); between two of them even in log r

  double mean_cube() const;  // mean of r^3 by number (m^3)
};

/// The radius of grain i (m).
double draw_radius(const RadiusDistribution& d, std::uint64_t seed, std::uint64_t i);

/// Number of grains in a class of a sieve curve for a unit of volume / (4 pi / 3), and their mean radius (m).
struct SieveClass {
  double number, mean;
};
SieveClass sieve_class(const RadiusDistribution& d, std::size_t k);

struct Sphere {
  Vec3 position;
  double radius;
};

struct Packing {
  Vec3 box = Vec3::Zero();  // m; corner at the origin
  std::vector<Sphere> spheres;
  double worst_overlap = 0;  // relative to the smaller radius
};

/// Random packing: spheres placed at random, grown and pushed apart until they fit at the target solid fraction; where
/// they do not, they change places and are shaken and grown again. About 0.64 for equal spheres in a periodic cell,
/// 0.66 for a radius ratio of 1:4; walls cost a few per cent. `count` = 0: as many radii as fill the fraction. Radii
/// are scaled by less than 2 % so that the fraction is exact. No overlap exceeds 1e-6 of a radius. Throws InputError
/// where the fraction is not reached, with the one that is.
/// In a cylinder the box is [diameter, diameter, height], its axis in the middle along z. `reach`: a sphere is as many
/// times larger than the solid in it as the next of these in turn says (empty: it is solid); such spheres do not change
/// places.
enum class Container { box, cylinder, periodic, periodic_xy };
/// The periodic cell in it (none: zero vectors), for spheres of at most this radius (m).
Cell cell_of(Container container, const Vec3& box, double largest);
double volume_of(Container container, const Vec3& box);

Packing random_packing(const Vec3& box, const RadiusDistribution& radius, double solid_fraction, std::size_t count,
                       Container container, std::uint64_t seed, Team& team, const Watch& watch,
                       const std::vector<double>& reach = {});
Packing random_packing(const Vec3& box, const RadiusDistribution& radius, double solid_fraction, std::size_t count,
                       bool periodic, std::uint64_t seed);

/// Equal spheres in contact, layers[k] of them along axis k; the box just holds them.
Packing simple_cubic(double radius, const std::array<int, 3>& layers);

/// Hexagonal close: close-packed layers stacked ABAB along z.
Packing hexagonal_close(double radius, const std::array<int, 3>& layers);

}  // namespace grus::dem
