// SPDX-License-Identifier: LGPL-3.0-or-later
// Forces of pairs, several at a time: plain pointers in and out, so that the code may be built for
// several instruction sets and chosen at run time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "dem/kernel/spring_rows.hpp"

namespace grus::dem {

/// How normal forces follow from overlaps in the kernels; each a row of contact_stages.hpp.
enum class KernelLaw { hertz, linear, jkr };

/// Rows of doubles, in the layout of the columns of the same names (state/grains.hpp, state/contacts.hpp).
struct ContactRows {
  const double* motion;         // 12: position radius | velocity 1/m | spin 1/I
  const std::uint32_t *a, *b;   // grains; as the next three readable by 8 beyond the end
  const std::uint32_t* law;     // row of `laws`
  const std::uint32_t* target;  // row of `load` that takes what b feels; for walls, the wall
  const std::uint32_t* shift;   // row of `shifts`; nullptr: no periodic cell
  const double* shifts;         // 8: offset of b, 0 | velocity of the offset, 0
  const double* walls;          // 8: normal, normal . point | velocity, 0
  const double* rounds;         // 8: point, radius | axis, 0 of cylinders; of planes 0; nullptr: all are planes
  const double* laws;           // 8: see LawRow
  std::size_t law_count;
  double dt;
  // A group of pairs of which none touches sleeps while `way` is less than its own of `until`.
  double* until;         // of each group of this call (m); nullptr: all are looked at
  double way;            // what gaps have lost so far, or more (m)
  double blur;           // round-off of a gap, or more (m)
  double* touch;         // 8: normal overlap | force, 0; nullptr for spheres: nobody looks at this step
  std::uint8_t* active;  // touching
  double* load;  // 8: force, 0 | torque, 0; added to. Rows of the grains of the tile at hand, that of `first` first
  double* elsewhere;  // the same of targets from `grains` on
  std::uint32_t grains, first;
  KernelLaw kernel;
  bool friction, dashpot, couples;  // what any pair needs; couples only with friction

  // Histories, a value a pair; as a and b readable beyond the end.
  double* spring[spring_rows][3];  // x, y, z; nullptr: not kept. The first always is
  double *compliance, *viscous;
  double *stiffness, *radius;  // written when a contact begins or parts
  double* reach;               // nullptr: no attraction

  // The law's word on pair k of spheres: it begins to touch, with what its stiffness follows from; it parts.
  void (*begin)(const void* context, std::size_t k, double effective_radius);
  void (*part)(const void* context, std::size_t k);

  // Poly-ellipsoids only.
  const double* frame;  // 12: octant origin, axes column by column
  const double* shape;  // 6: semi-axes plus, minus
  // Settles pair k one by one: begins or parts the contact where that is due. Touching: fills `found` with normal,
  // overlap, and the point of contact (global), and says so.
  bool (*solve)(const void* context, std::size_t k, double* found);
  const void* context;
};

/// Constants of a law, 8 a row; from `law_friction` on one for each spring: its largest force over the normal force.
enum LawRow : std::size_t { law_shear_ratio, law_dashpot, law_friction, law_columns = 8 };
static_assert(law_friction + std::size_t{spring_rows} <= law_columns);

/// Dissipation, and force x velocity of a moving cell or wall, over the pairs of this call. What friction takes is
/// known from what slides; `springs` is the same from the other side, the springs' work less the change of what they
/// hold.
struct PassEnergy {
  double friction = 0, springs = 0, viscous = 0, power = 0;
};

/// Pairs [begin, end): one thread's, whose rows of `load` no other thread writes.
using PairLoop = PassEnergy (*)(const ContactRows&, std::size_t begin, std::size_t end);

/// The widest that this machine can run; GRUS_LANES=1, 4 or 8 in the environment asks for less.
PairLoop sphere_pairs();
PairLoop sphere_walls();
PairLoop polyellipsoid_pairs();
int lanes();

/// The one that is compiled for the width that lanes() tells.
template <class T>
T of_width(T one, T four, T eight) {
  if (lanes() == 8) return eight;
  return lanes() == 4 ? four : one;
}

#define GRUS_DECLARE_LANES(name)                                                          \
  namespace name {                                                                        \
  PassEnergy sphere_pairs(const ContactRows&, std::size_t begin, std::size_t end);        \
  PassEnergy sphere_walls(const ContactRows&, std::size_t begin, std::size_t end);        \
  PassEnergy polyellipsoid_pairs(const ContactRows&, std::size_t begin, std::size_t end); \
  }
GRUS_DECLARE_LANES(lanes1)
GRUS_DECLARE_LANES(lanes4)
GRUS_DECLARE_LANES(lanes8)
#undef GRUS_DECLARE_LANES

}  // namespace grus::dem
