// SPDX-License-Identifier: LGPL-3.0-or-later
// The widest kernels that the machine runs.
#include <cstdlib>

#include "dem/kernel/contact_pass.hpp"
#include "dem/kernel/sphere_sweep.hpp"

namespace grus::dem {
namespace {

int widest() {
#if defined(GRUS_WIDE_KERNELS)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd"))
    return 8;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("fma")) return 4;
#endif
  return 1;
}

int chosen() {
  const int most = widest();
  const char* asked = std::getenv("GRUS_LANES");
  const int want = asked ? std::atoi(asked) : most;
  return want >= 8 && most >= 8 ? 8 : want >= 4 && most >= 4 ? 4 : 1;
}

}  // namespace

int lanes() {
  static const int n = chosen();
  return n;
}

#if defined(GRUS_WIDE_KERNELS)
PairLoop sphere_pairs() { return lanes() == 8 ? lanes8::sphere_pairs : lanes() == 4 ? lanes4::sphere_pairs : lanes1::sphere_pairs; }
PairLoop sphere_walls() { return lanes() == 8 ? lanes8::sphere_walls : lanes() == 4 ? lanes4::sphere_walls : lanes1::sphere_walls; }
PairLoop polyellipsoid_pairs() {
  return lanes() == 8 ? lanes8::polyellipsoid_pairs : lanes() == 4 ? lanes4::polyellipsoid_pairs : lanes1::polyellipsoid_pairs;
}
SphereKicks sphere_kicks() { return lanes() == 8 ? lanes8::sphere_kicks : lanes() == 4 ? lanes4::sphere_kicks : lanes1::sphere_kicks; }
#else
PairLoop sphere_pairs() { return lanes1::sphere_pairs; }
PairLoop sphere_walls() { return lanes1::sphere_walls; }
PairLoop polyellipsoid_pairs() { return lanes1::polyellipsoid_pairs; }
SphereKicks sphere_kicks() { return lanes1::sphere_kicks; }
#endif

}  // namespace grus::dem
