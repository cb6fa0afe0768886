// SPDX-License-Identifier: LGPL-3.0-or-later
// `width` doubles at a time, as the compiler's target allows: 8 (AVX-512), 4 (AVX2) or 1. What is fused is written
// so, and all else is rounded alone: all widths give the same bits. Everything is inlined: no symbol of one target can
// end up in another's code.
#pragma once

#include <cstdint>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace grus::dem {
namespace {

#define GRUS_INLINE [[gnu::always_inline]] inline

#if defined(__AVX512F__) && defined(__AVX512DQ__)
constexpr int width = 8;
using Mask = __mmask8;
struct Real {
  __m512d v;
  Real() = default;
  GRUS_INLINE Real(__m512d x) : v(x) {}
  GRUS_INLINE Real(double x) : v(_mm512_set1_pd(x)) {}
};
GRUS_INLINE Real operator+(Real a, Real b) { return _mm512_add_pd(a.v, b.v); }
GRUS_INLINE Real operator-(Real a, Real b) { return _mm512_sub_pd(a.v, b.v); }
GRUS_INLINE Real operator*(Real a, Real b) { return _mm512_mul_pd(a.v, b.v); }
GRUS_INLINE Real operator/(Real a, Real b) { return _mm512_div_pd(a.v, b.v); }
GRUS_INLINE Real fused(Real a, Real b, Real c) { return _mm512_fmadd_pd(a.v, b.v, c.v); }        // a b + c
GRUS_INLINE Real fused_less(Real a, Real b, Real c) { return _mm512_fmsub_pd(a.v, b.v, c.v); }   // a b - c
GRUS_INLINE Real less_fused(Real c, Real a, Real b) { return _mm512_fnmadd_pd(a.v, b.v, c.v); }  // c - a b
GRUS_INLINE Real root(Real a) { return _mm512_sqrt_pd(a.v); }
GRUS_INLINE Real halved_from(std::int64_t seed, Real a) {  // seed - (bits of a) / 2, as a number
  return _mm512_castsi512_pd(_mm512_sub_epi64(_mm512_set1_epi64(seed), _mm512_srli_epi64(_mm512_castpd_si512(a.v), 1)));
}
GRUS_INLINE Real taken_from(std::int64_t seed, Real a) {  // seed - bits of a
  return _mm512_castsi512_pd(_mm512_sub_epi64(_mm512_set1_epi64(seed), _mm512_castpd_si512(a.v)));
}
GRUS_INLINE Mask less(Real a, Real b) { return _mm512_cmp_pd_mask(a.v, b.v, _CMP_LT_OQ); }
GRUS_INLINE Real select(Mask m, Real a, Real b) { return _mm512_mask_blend_pd(m, b.v, a.v); }
GRUS_INLINE Real kept_lanes(Mask m, Real a) { return _mm512_maskz_mov_pd(m, a.v); }
GRUS_INLINE unsigned bits(Mask m) { return m; }
GRUS_INLINE Mask mask_of(unsigned b) { return static_cast<Mask>(b); }
GRUS_INLINE void store(Real a, double* to) { _mm512_storeu_pd(to, a.v); }
GRUS_INLINE void load(const double* from, Real& a) { a.v = _mm512_loadu_pd(from); }
GRUS_INLINE Real gather(const double* base, const std::uint32_t* at, int stride) {
  double x[8];
  for (int l = 0; l < 8; ++l) x[l] = base[at[l] * static_cast<std::size_t>(stride)];
  return _mm512_loadu_pd(x);
}

/// Columns 0..3 of `width` rows of four.
template <class At>
GRUS_INLINE void load4(const double* base, const At* at, std::size_t stride, Real& x, Real& y, Real& z, Real& w) {
  auto two = [&](int p, int q) {
    return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_loadu_pd(base + at[p] * stride)),
                              _mm256_loadu_pd(base + at[q] * stride), 1);
  };
  const __m512d r0 = two(0, 2), r1 = two(1, 3), r2 = two(4, 6), r3 = two(5, 7);
  const __m512d t0 = _mm512_unpacklo_pd(r0, r1), t1 = _mm512_unpackhi_pd(r0, r1);
  const __m512d t2 = _mm512_unpacklo_pd(r2, r3), t3 = _mm512_unpackhi_pd(r2, r3);
  x = _mm512_shuffle_f64x2(t0, t2, 0x88), z = _mm512_shuffle_f64x2(t0, t2, 0xdd);
  y = _mm512_shuffle_f64x2(t1, t3, 0x88), w = _mm512_shuffle_f64x2(t1, t3, 0xdd);
}

GRUS_INLINE unsigned flags(const std::uint8_t* of) {  // bytes 0 or 1
  std::uint64_t x;
  __builtin_memcpy(&x, of, 8);
  return static_cast<unsigned>(x * 0x0102040810204080ull >> 56);
}

/// Rows of eight from eight columns.
struct Rows {
  __m512d row[8];
};
struct Quads {  // rows of four, two to a register: 0|2, 1|3, 4|6, 5|7
  __m512d q[4];
};
GRUS_INLINE Quads quads(Real x, Real y, Real z, Real w) {
  const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11), high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
  const __m512d t0 = _mm512_unpacklo_pd(x.v, y.v), t1 = _mm512_unpackhi_pd(x.v, y.v);
  const __m512d u0 = _mm512_unpacklo_pd(z.v, w.v), u1 = _mm512_unpackhi_pd(z.v, w.v);
  return {{_mm512_permutex2var_pd(t0, low, u0), _mm512_permutex2var_pd(t1, low, u1),
           _mm512_permutex2var_pd(t0, high, u0), _mm512_permutex2var_pd(t1, high, u1)}};
}
GRUS_INLINE Rows rows(const Quads& a, const Quads& b) {
  Rows r;
  for (int k = 0; k < 4; ++k) {
    const int first = k < 2 ? k : k + 2;
    r.row[first] = _mm512_shuffle_f64x2(a.q[k], b.q[k], 0x44);
    r.row[first + 2] = _mm512_shuffle_f64x2(a.q[k], b.q[k], 0xee);
  }
  return r;
}
/// Sums over eight lanes of four numbers, each in one order: ((0 + 1) + (2 + 3)) + ((4 + 5) + (6 + 7)).
GRUS_INLINE void add_eight(const Real* x, const Real* y, const Real* z, const Real* w, double* to) {
  const Quads r = quads(*x, *y, *z, *w);
  const __m512d low = _mm512_add_pd(r.q[0], r.q[1]), high = _mm512_add_pd(r.q[2], r.q[3]);
  const auto half = [](__m512d of) { return _mm256_add_pd(_mm512_castpd512_pd256(of), _mm512_extractf64x4_pd(of, 1)); };
  _mm256_storeu_pd(to, _mm256_add_pd(half(low), half(high)));
}
GRUS_INLINE void put(const Quads& r, int l, double* to) {  // row l
  const __m512d two = r.q[l / 4 * 2 + l % 2];
  _mm256_storeu_pd(to, l / 2 % 2 ? _mm512_extractf64x4_pd(two, 1) : _mm512_castpd512_pd256(two));
}
GRUS_INLINE void put(const Rows& r, int l, double* to) { _mm512_storeu_pd(to, r.row[l]); }
GRUS_INLINE void add(const Rows& r, int l, double* to) {
  _mm512_storeu_pd(to, _mm512_add_pd(_mm512_loadu_pd(to), r.row[l]));
}
GRUS_INLINE void subtract(const Rows& r, int l, double* to) {
  _mm512_storeu_pd(to, _mm512_sub_pd(_mm512_loadu_pd(to), r.row[l]));
}

#elif defined(__AVX2__)
constexpr int width = 4;
struct Mask {
  __m256d v;
};
struct Real {
  __m256d v;
  Real() = default;
  GRUS_INLINE Real(__m256d x) : v(x) {}
  GRUS_INLINE Real(double x) : v(_mm256_set1_pd(x)) {}
};
GRUS_INLINE Real operator+(Real a, Real b) { return _mm256_add_pd(a.v, b.v); }
GRUS_INLINE Real operator-(Real a, Real b) { return _mm256_sub_pd(a.v, b.v); }
GRUS_INLINE Real operator*(Real a, Real b) { return _mm256_mul_pd(a.v, b.v); }
GRUS_INLINE Real operator/(Real a, Real b) { return _mm256_div_pd(a.v, b.v); }
GRUS_INLINE Real fused(Real a, Real b, Real c) { return _mm256_fmadd_pd(a.v, b.v, c.v); }
GRUS_INLINE Real fused_less(Real a, Real b, Real c) { return _mm256_fmsub_pd(a.v, b.v, c.v); }
GRUS_INLINE Real less_fused(Real c, Real a, Real b) { return _mm256_fnmadd_pd(a.v, b.v, c.v); }
GRUS_INLINE Real root(Real a) { return _mm256_sqrt_pd(a.v); }
GRUS_INLINE Real halved_from(std::int64_t seed, Real a) {
  return _mm256_castsi256_pd(
      _mm256_sub_epi64(_mm256_set1_epi64x(seed), _mm256_srli_epi64(_mm256_castpd_si256(a.v), 1)));
}
GRUS_INLINE Real taken_from(std::int64_t seed, Real a) {
  return _mm256_castsi256_pd(_mm256_sub_epi64(_mm256_set1_epi64x(seed), _mm256_castpd_si256(a.v)));
}
GRUS_INLINE Mask less(Real a, Real b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LT_OQ)}; }
GRUS_INLINE Real select(Mask m, Real a, Real b) { return _mm256_blendv_pd(b.v, a.v, m.v); }
GRUS_INLINE Real kept_lanes(Mask m, Real a) { return _mm256_and_pd(m.v, a.v); }
GRUS_INLINE unsigned bits(Mask m) { return static_cast<unsigned>(_mm256_movemask_pd(m.v)); }
GRUS_INLINE Mask mask_of(unsigned b) {
  const __m256i bit = _mm256_setr_epi64x(1, 2, 4, 8), all = _mm256_set1_epi64x(static_cast<long long>(b));
  return {_mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(all, bit), bit))};
}
GRUS_INLINE void store(Real a, double* to) { _mm256_storeu_pd(to, a.v); }
GRUS_INLINE void load(const double* from, Real& a) { a.v = _mm256_loadu_pd(from); }
GRUS_INLINE Real gather(const double* base, const std::uint32_t* at, int stride) {
  double x[4];
  for (int l = 0; l < 4; ++l) x[l] = base[at[l] * static_cast<std::size_t>(stride)];
  return _mm256_loadu_pd(x);
}
template <class At>
GRUS_INLINE void load4(const double* base, const At* at, std::size_t stride, Real& x, Real& y, Real& z, Real& w) {
  const __m256d r0 = _mm256_loadu_pd(base + at[0] * stride), r1 = _mm256_loadu_pd(base + at[1] * stride);
  const __m256d r2 = _mm256_loadu_pd(base + at[2] * stride), r3 = _mm256_loadu_pd(base + at[3] * stride);
  const __m256d t0 = _mm256_unpacklo_pd(r0, r1), t1 = _mm256_unpackhi_pd(r0, r1);
  const __m256d t2 = _mm256_unpacklo_pd(r2, r3), t3 = _mm256_unpackhi_pd(r2, r3);
  x = _mm256_permute2f128_pd(t0, t2, 0x20), z = _mm256_permute2f128_pd(t0, t2, 0x31);
  y = _mm256_permute2f128_pd(t1, t3, 0x20), w = _mm256_permute2f128_pd(t1, t3, 0x31);
}
GRUS_INLINE unsigned flags(const std::uint8_t* of) {
  std::uint32_t x;
  __builtin_memcpy(&x, of, 4);
  return (x * 0x10204080u) >> 28;
}
struct Quads {
  __m256d q[4];
};
struct Rows {
  Quads a, b;
};
GRUS_INLINE Quads quads(Real x, Real y, Real z, Real w) {
  const __m256d t0 = _mm256_unpacklo_pd(x.v, y.v), t1 = _mm256_unpackhi_pd(x.v, y.v);
  const __m256d u0 = _mm256_unpacklo_pd(z.v, w.v), u1 = _mm256_unpackhi_pd(z.v, w.v);
  return {{_mm256_permute2f128_pd(t0, u0, 0x20), _mm256_permute2f128_pd(t1, u1, 0x20),
           _mm256_permute2f128_pd(t0, u0, 0x31), _mm256_permute2f128_pd(t1, u1, 0x31)}};
}
GRUS_INLINE void add_eight(const Real* x, const Real* y, const Real* z, const Real* w, double* to) {
  const auto four = [&](int k) {
    const Quads r = quads(x[k], y[k], z[k], w[k]);
    return _mm256_add_pd(_mm256_add_pd(r.q[0], r.q[1]), _mm256_add_pd(r.q[2], r.q[3]));
  };
  _mm256_storeu_pd(to, _mm256_add_pd(four(0), four(1)));
}
GRUS_INLINE Rows rows(const Quads& a, const Quads& b) { return {a, b}; }
GRUS_INLINE void put(const Quads& r, int l, double* to) { _mm256_storeu_pd(to, r.q[l]); }
GRUS_INLINE void put(const Rows& r, int l, double* to) {
  _mm256_storeu_pd(to, r.a.q[l]), _mm256_storeu_pd(to + 4, r.b.q[l]);
}
GRUS_INLINE void add(const Rows& r, int l, double* to) {
  _mm256_storeu_pd(to, _mm256_add_pd(_mm256_loadu_pd(to), r.a.q[l]));
  _mm256_storeu_pd(to + 4, _mm256_add_pd(_mm256_loadu_pd(to + 4), r.b.q[l]));
}
GRUS_INLINE void subtract(const Rows& r, int l, double* to) {
  _mm256_storeu_pd(to, _mm256_sub_pd(_mm256_loadu_pd(to), r.a.q[l]));
  _mm256_storeu_pd(to + 4, _mm256_sub_pd(_mm256_loadu_pd(to + 4), r.b.q[l]));
}

#else
constexpr int width = 1;
using Mask = bool;
using Real = double;
GRUS_INLINE double fused(double a, double b, double c) { return __builtin_fma(a, b, c); }
GRUS_INLINE double fused_less(double a, double b, double c) { return __builtin_fma(a, b, -c); }
GRUS_INLINE double less_fused(double c, double a, double b) { return __builtin_fma(-a, b, c); }
GRUS_INLINE double root(double a) { return __builtin_sqrt(a); }
GRUS_INLINE double halved_from(std::int64_t seed, double a) {
  std::uint64_t i;
  __builtin_memcpy(&i, &a, 8);
  i = static_cast<std::uint64_t>(seed) - (i >> 1);
  __builtin_memcpy(&a, &i, 8);
  return a;
}
GRUS_INLINE double taken_from(std::int64_t seed, double a) {
  std::uint64_t i;
  __builtin_memcpy(&i, &a, 8);
  i = static_cast<std::uint64_t>(seed) - i;
  __builtin_memcpy(&a, &i, 8);
  return a;
}
GRUS_INLINE bool less(double a, double b) { return a < b; }
GRUS_INLINE double select(bool m, double a, double b) { return m ? a : b; }
GRUS_INLINE double kept_lanes(bool m, double a) { return m ? a : 0.0; }
GRUS_INLINE unsigned bits(bool m) { return m; }
GRUS_INLINE bool mask_of(unsigned b) { return b & 1; }
GRUS_INLINE void store(double a, double* to) { *to = a; }
GRUS_INLINE void load(const double* from, double& a) { a = *from; }
GRUS_INLINE double gather(const double* base, const std::uint32_t* at, int stride) {
  return base[at[0] * static_cast<std::size_t>(stride)];
}
template <class At>
GRUS_INLINE void load4(const double* base, const At* at, std::size_t stride, double& x, double& y, double& z,
                       double& w) {
  const double* r = base + at[0] * stride;
  x = r[0];
  y = r[1];
  z = r[2];
  w = r[3];
}
GRUS_INLINE unsigned flags(const std::uint8_t* of) { return *of; }
struct Quads {
  double q[4];
};
struct Rows {
  double row[8];
};
GRUS_INLINE Quads quads(double x, double y, double z, double w) { return {{x, y, z, w}}; }
GRUS_INLINE void add_eight(const Real* x, const Real* y, const Real* z, const Real* w, double* to) {
  const Real* const of[4] = {x, y, z, w};
  for (int k = 0; k < 4; ++k) {
    const double* v = of[k];
    to[k] = ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
  }
}
GRUS_INLINE Rows rows(const Quads& a, const Quads& b) {
  return {{a.q[0], a.q[1], a.q[2], a.q[3], b.q[0], b.q[1], b.q[2], b.q[3]}};
}
GRUS_INLINE void put(const Quads& r, int, double* to) {
  for (int k = 0; k < 4; ++k) to[k] = r.q[k];
}
GRUS_INLINE void put(const Rows& r, int, double* to) {
  for (int k = 0; k < 8; ++k) to[k] = r.row[k];
}
GRUS_INLINE void add(const Rows& r, int, double* to) {
  for (int k = 0; k < 8; ++k) to[k] = to[k] + r.row[k];
}
GRUS_INLINE void subtract(const Rows& r, int, double* to) {
  for (int k = 0; k < 8; ++k) to[k] = to[k] - r.row[k];
}
#endif

GRUS_INLINE Real larger(Real a, Real b) { return select(less(a, b), b, a); }
GRUS_INLINE Real smaller(Real a, Real b) { return select(less(b, a), b, a); }
GRUS_INLINE double least_of(Real a) {
  double x[width];
  store(a, x);
  for (int l = 1; l < width; ++l) x[0] = x[l] < x[0] ? x[l] : x[0];
  return x[0];
}

/// The same of consecutive rows.
GRUS_INLINE void load4(const double* base, std::size_t stride, Real& x, Real& y, Real& z, Real& w) {
  constexpr std::uint32_t each[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  load4(base, each, stride, x, y, z, w);
}

// Roots and quotients by Newton's iteration, where many are wanted at once: a divider does one at a time, the
// multipliers do many. The seeds are good to 3.5 % and 5 %, every step squares the error: four end within two units of
// the last place. For positive normal numbers; of 0 they give something large, and the inverse may overflow.
GRUS_INLINE Real inverse_root(Real a) {
  Real y = halved_from(0x5fe6eb50c7b537a9, a);
  const Real half_a = Real(0.5) * a;
  for (int k = 0; k < 4; ++k) y = y * less_fused(Real(1.5), half_a * y, y);
  return y;
}
GRUS_INLINE Real inverse(Real a) {
  Real y = taken_from(0x7fde623822fc16e6, a);
  for (int k = 0; k < 4; ++k) y = y * less_fused(Real(2.0), a, y);
  return y;
}

struct Real3 {
  Real x, y, z;
};
GRUS_INLINE Real3 operator+(const Real3& a, const Real3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
GRUS_INLINE Real3 operator-(const Real3& a, const Real3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
GRUS_INLINE Real3 operator*(Real s, const Real3& a) { return {s * a.x, s * a.y, s * a.z}; }
GRUS_INLINE Real3 fused(Real s, const Real3& a, const Real3& b) {
  return {fused(s, a.x, b.x), fused(s, a.y, b.y), fused(s, a.z, b.z)};
}
GRUS_INLINE Real3 less_fused(const Real3& b, Real s, const Real3& a) {
  return {less_fused(b.x, s, a.x), less_fused(b.y, s, a.y), less_fused(b.z, s, a.z)};
}
GRUS_INLINE Real dot(const Real3& a, const Real3& b) { return fused(a.z, b.z, fused(a.y, b.y, a.x * b.x)); }
GRUS_INLINE Real3 cross(const Real3& a, const Real3& b) {
  return {fused_less(a.y, b.z, a.z * b.y), fused_less(a.z, b.x, a.x * b.z), fused_less(a.x, b.y, a.y * b.x)};
}

}  // namespace
}  // namespace grus::dem
