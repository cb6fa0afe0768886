// SPDX-License-Identifier: LGPL-3.0-or-later
// How dense spheres can lie: they are pressed, shaken and pressed again, in a course that nobody's wish enters.
#pragma once

#include "dem/packing/packing.hpp"

namespace grus::dem {

/// Spheres as dense as a course of pressing has brought them: all radii times `share` leave no overlap.
struct Pressed {
  std::vector<Sphere> spheres;
  double share;
};

/// How long a course may take and how it is watched. `enough`: share at which it ends early; `swaps`: spheres may
/// change places; `margin`: spheres are grown by so much more, so that their final radii leave no overlap; `watch`:
/// asked with the iterations so far.
struct Course {
  int cycles;
  double enough;
  bool swaps;
  double margin;
  std::function<void(double)> watch;
};

/// Iterations that a course of so many cycles takes at most.
double pressing_steps(int cycles);

/// Presses `spheres` from where they are thrown in; `share` is about what they fill 0.64 of the box with. Where a
/// course gets to depends on spheres and seed alone, but that it ends where `enough` is reached.
Pressed press(const Vec3& box, Container container, std::vector<Sphere> spheres, double share, std::uint64_t seed,
              const Course& course, Team& team);

}  // namespace grus::dem
