// SPDX-License-Identifier: LGPL-3.0-or-later
// Built once for each instruction set, with GRUS_LANES naming the namespace; see sphere_pass.cpp.
#include "dem/kernel/sweep.hpp"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace grus::dem {
namespace {

#define GRUS_INLINE [[gnu::always_inline]] inline

using Four = double __attribute__((vector_size(32)));
struct [[gnu::packed,
         gnu::may_alias]] RowAnywhere {  // rows are aligned as doubles; clang forgets that of a vector type alone
  Four four;
};

#define GRUS_ROW(p) (reinterpret_cast<RowAnywhere*>(p)->four)
#define GRUS_ALL(x) (Four{(x), (x), (x), (x)})

using Two = double __attribute__((vector_size(16)));
#ifdef __SSE2__
GRUS_INLINE Two roots(const Two& a) { return _mm_sqrt_pd(a); }
#else
GRUS_INLINE Two roots(const Two& a) { return Two{__builtin_sqrt(a[0]), __builtin_sqrt(a[1])}; }
#endif

/// -damping |force| against the direction of the velocity, and the same of the torque and the spin: no axis is special.
/// Both in one division and one root, which are what a kick waits for.
struct Against {
  Four force, torque;
};
GRUS_INLINE Against opposing(const Four& force, const Four& velocity, const Four& torque, const Four& spin,
                             double damping) {
  const Four ff = force * force, vv = velocity * velocity, tt = torque * torque, ww = spin * spin;
  const Two pull{ff[0] + ff[1] + ff[2], tt[0] + tt[1] + tt[2]}, speed{vv[0] + vv[1] + vv[2], ww[0] + ww[1] + ww[2]};
  const Two some = -damping * roots(pull / speed), share = speed > 0 ? some : Two{};  // at rest there is no direction
  return {Four{share[0], share[0], share[0], 0} * velocity, Four{share[1], share[1], share[1], 0} * spin};
}

template <bool damped, bool weighs, bool shears, bool close, bool open>
GRUS_INLINE SweepEnergy run(const SweepRows& s, std::size_t begin, std::size_t end) {
  const Four zero{0, 0, 0, 0}, three{1, 1, 1, 0};
  const double h = 0.5 * s.dt;
  const Four gravity{s.gravity[0], s.gravity[1], s.gravity[2], 0};
  const Four ax{s.affine[0], s.affine[1], s.affine[2], 0}, ay{s.affine[3], s.affine[4], s.affine[5], 0},
      az{s.affine[6], s.affine[7], s.affine[8], 0};
  const Four step{s.dt, s.dt, s.dt, 0};
  Four viscous = zero, work = zero, fastest = zero;
  for (std::size_t i = begin; i < end; ++i) {
    double* const m = s.motion + 12 * i;
    Four x = GRUS_ROW(m), v = GRUS_ROW(m + 4), w = GRUS_ROW(m + 8), force, torque;
    const double kick = h * v[3], turn = h * w[3];
    if constexpr (close) {
      double* row = s.load + 8 * (i - s.first);
      force = GRUS_ROW(row), torque = GRUS_ROW(row + 4);
      GRUS_ROW(row) = zero, GRUS_ROW(row + 4) = zero;
      for (std::uint32_t r = s.remote[i]; r < s.remote[i + 1]; ++r) {
        row = s.elsewhere + 8 * std::size_t{s.remote_row[r]};
        __builtin_prefetch(s.elsewhere + 8 * std::size_t{s.remote_row[r + rows_ahead]}, 1);
        force = force + GRUS_ROW(row), torque = torque + GRUS_ROW(row + 4);
        GRUS_ROW(row) = zero, GRUS_ROW(row + 4) = zero;
      }
      if constexpr (weighs) force = force + GRUS_ALL(s.mass[i]) * gravity;
      if (s.bonded) {
        const double *f = s.force + 3 * i, *t = s.torque + 3 * i;
        force = force + Four{f[0], f[1], f[2], 0}, torque = torque + Four{t[0], t[1], t[2], 0};
      }
      if constexpr (!open)
        for (int k = 0; k < 3; ++k)
          s.force[3 * i + static_cast<std::size_t>(k)] = force[k],
                          s.torque[3 * i + static_cast<std::size_t>(k)] = torque[k];
    } else {
      const double *f = s.force + 3 * i, *t = s.torque + 3 * i;
      force = Four{f[0], f[1], f[2], 0}, torque = Four{t[0], t[1], t[2], 0};
    }
    auto affine = [&] { return ax * GRUS_ALL(x[0]) + ay * GRUS_ALL(x[1]) + az * GRUS_ALL(x[2]); };
    for (int half = 0; half < (close && open ? 2 : 1); ++half) {
      Four f = force, t = torque;
      if constexpr (damped) {
        const double damping = s.damping[s.material[i]];
        const auto [df, dt] = opposing(force, shears ? Four(v - affine()) : v, torque, w, damping);
        f = f + df, t = t + dt;
        viscous = viscous - GRUS_ALL(h) * (df * (v + GRUS_ALL(0.5 * kick) * f) + dt * w);
      }
      if constexpr (weighs) work = work + GRUS_ALL(h * s.mass[i]) * (gravity * (v + GRUS_ALL(0.5 * kick) * f));
      v = v + GRUS_ALL(kick) * f;  // forces have no fourth: 1/m and 1/I stay
      w = w + GRUS_ALL(turn) * t;
    }
    GRUS_ROW(m + 4) = v, GRUS_ROW(m + 8) = w;
    if constexpr (open) {
      const Four apart = three * (shears ? Four(v - affine()) : v), speed2 = apart * apart;
      fastest = speed2 > fastest ? speed2 : fastest;
      GRUS_ROW(m) = x + step * v;
    } else {
      for (int k = 0; k < 3; ++k)
        s.angular_momentum[3 * i + static_cast<std::size_t>(k)] = w[3] > 0 ? w[k] / w[3] : 0;  // 0: it does not turn
    }
  }
  return {viscous[0] + viscous[1] + viscous[2], work[0] + work[1] + work[2], fastest[0] + fastest[1] + fastest[2]};
}

template <bool damped, bool weighs, bool shears>
SweepEnergy choose(const SweepRows& s, Kick kick, std::size_t begin, std::size_t end) {
  if (kick == Kick::both) return run<damped, weighs, shears, true, true>(s, begin, end);
  return kick == Kick::close ? run<damped, weighs, shears, true, false>(s, begin, end)
                             : run<damped, weighs, shears, false, true>(s, begin, end);
}

}  // namespace

namespace GRUS_LANES {
SweepEnergy sphere_kicks(const SweepRows& s, Kick k, std::size_t b, std::size_t e) {
  if (s.damping) {
    if (s.weighs) return s.shears ? choose<true, true, true>(s, k, b, e) : choose<true, true, false>(s, k, b, e);
    return s.shears ? choose<true, false, true>(s, k, b, e) : choose<true, false, false>(s, k, b, e);
  }
  if (s.weighs) return s.shears ? choose<false, true, true>(s, k, b, e) : choose<false, true, false>(s, k, b, e);
  return s.shears ? choose<false, false, true>(s, k, b, e) : choose<false, false, false>(s, k, b, e);
}
}  // namespace GRUS_LANES

}  // namespace grus::dem
