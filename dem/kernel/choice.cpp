// SPDX-License-Identifier: LGPL-3.0-or-later
// The widest kernels that the machine runs.
#include <algorithm>
#include <cstdlib>

#include "dem/kernel/contact_pass.hpp"
#include "dem/kernel/hull_overlap.hpp"
#include "dem/kernel/lattice_pass.hpp"
#include "dem/kernel/sweep.hpp"

namespace grus::dem {
namespace {

int widest() {
#if defined(GRUS_WIDE_KERNELS)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd"))
    return 8;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
      __builtin_cpu_supports("fma"))
    return 4;
#endif
  return 1;
}

int chosen() {
  const int most = widest();
  const char* asked = std::getenv("GRUS_LANES");
  const int want = asked ? std::atoi(asked) : most;
  const int allowed = std::min(want, most);
  if (allowed >= 8) return 8;
  return allowed >= 4 ? 4 : 1;
}

}  // namespace

int lanes() {
  static const int n = chosen();
  return n;
}

#if defined(GRUS_WIDE_KERNELS)
#define GRUS_CHOICE(name) of_width(&lanes1::name, &lanes4::name, &lanes8::name)
#else
#define GRUS_CHOICE(name) lanes1::name
#endif

PairLoop sphere_pairs() { return GRUS_CHOICE(sphere_pairs); }
PairLoop sphere_walls() { return GRUS_CHOICE(sphere_walls); }
PairLoop polyellipsoid_pairs() { return GRUS_CHOICE(polyellipsoid_pairs); }
SphereKicks sphere_kicks() { return GRUS_CHOICE(sphere_kicks); }
BodyKicks body_kicks() { return GRUS_CHOICE(body_kicks); }
HullOverlap hull_overlap() { return GRUS_CHOICE(hull_overlap); }
LatticeDilation lattice_dilation() { return GRUS_CHOICE(lattice_dilation); }
LatticeForces lattice_forces() { return GRUS_CHOICE(lattice_forces); }
LatticeStiffness lattice_stiffness() { return GRUS_CHOICE(lattice_stiffness); }
LatticeBreaks lattice_breaks() { return GRUS_CHOICE(lattice_breaks); }
LatticeStretch lattice_stretch() { return GRUS_CHOICE(lattice_stretch); }
SphereTurns sphere_turns() { return GRUS_CHOICE(sphere_turns); }

}  // namespace grus::dem
