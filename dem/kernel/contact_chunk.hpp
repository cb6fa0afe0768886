// SPDX-License-Identifier: LGPL-3.0-or-later
// Chunks that the stages of a contact pass hand on, `chunk` pairs at a time. Only for the files that are built once for
// each instruction set.
#pragma once

#include "dem/kernel/contact_pass.hpp"
#include "dem/kernel/lanes.hpp"
#include "dem/kernel/look_ahead.hpp"

namespace grus::dem {
namespace {

#define GRUS_STAGE [[gnu::noinline]] static

enum class Kind {
  spheres,
  walls,
  shaped
};  // sphere on sphere, sphere on wall, pairs whose points of contact are given

constexpr int group = 8;   // contacts whose energies are summed apart: the same sums for any width
constexpr int chunk = 64;  // pairs that go through the stages together: short chains of operations, many at a time

/// A chunk, as it goes from stage to stage; columns of `chunk` values, in the order of the kept groups.
struct alignas(64) Chunk {
  double nx[chunk], ny[chunk], nz[chunk], overlap[chunk], la[chunk], lb[chunk];  // normal; levers of spheres
  double arm_ax[chunk], arm_ay[chunk], arm_az[chunk], arm_bx[chunk], arm_by[chunk], arm_bz[chunk];  // of other shapes
  double vx[chunk], vy[chunk], vz[chunk], turn[chunk];  // velocity of b against a, mean turn about n in this step
  double drag_x[chunk], drag_y[chunk], drag_z[chunk];   // velocity of the wall or the cell
  double elastic[chunk], kt[chunk], compliance[chunk], dashpot[chunk], normal[chunk];
  double sx[chunk], sy[chunk], sz[chunk], keep[chunk], cut[chunk], size[chunk];  // springs
  double before[chunk], mx[chunk], my[chunk], mz[chunk];  // of couples: compliance of the step before; couple on b
  std::size_t first[chunk / width];                       // pair of each kept group
  unsigned touching[chunk / width];
  int count[chunk / width];
  double pull[chunk], borne[chunk];  // of laws that attract: what parts the contact; what friction counts as normal

  /// Where the energies of kept group g are summed, in a call that began at pair `begin`.
  int place(int g, std::size_t begin) const { return static_cast<int>((first[g] - begin) / width % (group / width)); }
};

/// The answer of a law to an overlap: force and stiffness of the area, and of laws that attract the force that parts
/// it.
struct Pressed {
  Real force, grip, pull;
};

GRUS_INLINE Real at(const double* column) {
  Real x;
  load(column, x);
  return x;
}

/// Energy (J) that the springs of a parting pair still held.
GRUS_INLINE double part(const ContactRows& s, std::size_t k) {
  double size2 = 0;
  for (double* const* spring : s.spring) {
    if (!spring[0]) continue;
    double &x = spring[0][k], &y = spring[1][k], &z = spring[2][k];
    size2 += x * x + y * y + z * z;
    x = y = z = 0;
  }
  const double held = 0.5 * s.compliance[k] * size2;
  s.compliance[k] = s.viscous[k] = s.stiffness[k] = s.radius[k] = 0;
  if (s.reach) s.reach[k] = 0;
  return held;
}

/// The first `count` lanes, to a column of the histories.
GRUS_INLINE void put_back(Real x, int count, double* to) {
  if (count == width) return store(x, to);
  double lane[width];
  store(x, lane);
  for (int l = 0; l < count; ++l) to[l] = lane[l];
}

/// Of a sample that is larger than a core's own cache.
GRUS_INLINE bool far(const ContactRows& s) { return s.grains > near_grains; }

/// The grains b of the group that is `grains_ahead` further on: no processor foresees where they are. Both lines of a
/// row of motion. Grains a come in their order, which processors do foresee.
GRUS_INLINE void ask_for_grains(const ContactRows& s, std::size_t k) {
  const std::uint32_t* const b = s.b + k + grains_ahead;
  for (int l = 0; l < width; ++l) {
    __builtin_prefetch(s.motion + 12 * std::size_t{b[l]});
    __builtin_prefetch(s.motion + 12 * std::size_t{b[l]} + 8);
  }
}

/// The histories of the group that is `histories_ahead` further on: more columns than processors follow at a time.
GRUS_INLINE void ask_for_histories(const ContactRows& s, std::size_t k) {
  k += histories_ahead;
  __builtin_prefetch(s.stiffness + k);
  __builtin_prefetch(s.compliance + k, 1);
  __builtin_prefetch(s.viscous + k, 1);
  for (double* column : s.spring[slide_spring]) __builtin_prefetch(column + k, 1);
}

/// Law constant k of the pairs from `first` on.
GRUS_INLINE Real constant(const ContactRows& s, std::size_t k, std::size_t first) {
  return s.law_count == 1 ? Real(s.laws[k]) : gather(s.laws + k, s.law + first, law_columns);
}

/// Sums of one call, one for each of `group` places: twice what springs lost, and of it what friction took; what
/// dashpots took over - dt / 2; power.
struct Sums {
  Real lost[group / width], slid[group / width], spent[group / width], power[group / width];
};

}  // namespace
}  // namespace grus::dem
