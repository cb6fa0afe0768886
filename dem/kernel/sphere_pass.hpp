// SPDX-License-Identifier: LGPL-3.0-or-later
// Forces of spheres on spheres and walls, several pairs at a time: plain pointers in and out, so that the code may be built for
// several instruction sets and chosen at run time.
#pragma once

#include <cstddef>
#include <cstdint>

namespace grus::dem {

/// Rows of doubles, in the layout of the columns of the same names (state/grains.hpp, state/contacts.hpp).
struct SpherePass {
  const double* motion;          // 12: position radius | velocity 1/m | spin 1/I
  const std::uint32_t *a, *b;    // grains, or grain and wall; as `law` and `shift` readable by 8 beyond the end
  const std::uint32_t* law;      // row of `laws`
  const std::uint32_t* target;   // row of `load` that takes what b feels
  const std::uint32_t* shift;    // row of `shifts`; nullptr: no periodic cell
  const double* shifts;          // 8: offset of b, 0 | velocity of the offset, 0
  const double* walls;           // 8: normal, normal . point | velocity, 0
  const double* laws;            // 8: see law_row
  std::size_t law_count;
  double dt;
  double* contact;               // 8: spring k | effective mass, compliance, viscous, radius
  double* touch;                 // 8: normal overlap | force, 0; nullptr: nobody looks at this step
  std::uint8_t* active;          // touching
  double* load;                  // 8: force, 0 | torque, 0; added to. Rows of the grains of the tile at hand
  double* elsewhere;             // the same of targets from `grains` on
  std::uint32_t grains;
  bool hertz, friction, dashpot; // what any of the laws needs
};

enum LawRow { law_youngs, law_shear_ratio, law_friction, law_dashpot, law_stiffness, law_columns = 8 };

/// Dissipation, and force x velocity of a moving cell or wall, over the pairs of this call.
struct PassEnergy {
  double friction = 0, viscous = 0, power = 0;
};

/// Pairs [begin, end): one thread's, whose rows of `load` no other thread writes.
using SpherePairs = PassEnergy (*)(const SpherePass&, std::size_t begin, std::size_t end);

/// The widest that this machine can run; GRUS_LANES=1, 4 or 8 in the environment asks for less.
SpherePairs sphere_pairs();
SpherePairs sphere_walls();
int lanes();

namespace lanes1 { PassEnergy sphere_pairs(const SpherePass&, std::size_t, std::size_t), sphere_walls(const SpherePass&, std::size_t, std::size_t); }
namespace lanes4 { PassEnergy sphere_pairs(const SpherePass&, std::size_t, std::size_t), sphere_walls(const SpherePass&, std::size_t, std::size_t); }
namespace lanes8 { PassEnergy sphere_pairs(const SpherePass&, std::size_t, std::size_t), sphere_walls(const SpherePass&, std::size_t, std::size_t); }

}  // namespace grus::dem
