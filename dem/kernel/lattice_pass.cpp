// SPDX-License-Identifier: LGPL-3.0-or-later
// Built once for each instruction set, with GRUS_LANES naming the namespace; see sphere_pass.cpp. Each point adds up
// over its own bonds in the order of the ways, whatever the width. The extension of a bond has the same bits from both
// ends: differences and unit vector change sign together.
#include "dem/kernel/lattice_pass.hpp"

#include "dem/kernel/lanes.hpp"

namespace grus::dem {
namespace {

GRUS_INLINE Real3 at(const LatticeColumns& u, std::ptrdiff_t cell) {
  Real3 r;
  load(u.x + cell, r.x), load(u.y + cell, r.y), load(u.z + cell, r.z);
  return r;
}

GRUS_INLINE Real extension(const LatticeWay& w, const Real3& here, const Real3& there) {
  const Real3 d = there - here;
  return fused(w.along[2], d.z, fused(w.along[1], d.y, Real(w.along[0]) * d.x));
}

GRUS_INLINE unsigned some(int eight, int lane) {
  constexpr unsigned all = (1u << width) - 1;
  return static_cast<unsigned>(eight) >> lane & all;
}

/// Calls f(octet, its first point here: cell, lane) for each group of `width` points, octet by octet.
template <class F>
GRUS_INLINE void each_group(const LatticeRows& rows, F&& f) {
  for (std::size_t k = 0; k < rows.octets; ++k) {
    const int count = static_cast<int>(rows.octet[k + 1].point - rows.octet[k].point);
    for (int lane = 0; lane < count; lane += width) f(k, static_cast<std::ptrdiff_t>(rows.octet[k].cell) + lane, lane);
  }
}

template <bool squares>
GRUS_INLINE void dilation(const LatticeRows& rows, const std::uint8_t* intact, const LatticeColumns& u,
                          const double* factor, double* sum, double* square) {
  each_group(rows, [&](std::size_t k, std::ptrdiff_t cell, int lane) {
    const Real3 here = at(u, cell);
    Real total(0.0), total2(0.0), scale;
    for (std::uint32_t b = rows.octet[k].bond; b < rows.octet[k + 1].bond; ++b) {
      const LatticeWay& w = rows.ways[rows.way[b]];
      const Real e = kept_lanes(mask_of(some(intact[b], lane)), extension(w, here, at(u, cell + w.step)));
      total = fused(Real(w.moment), e, total);
      if constexpr (squares) total2 = fused(Real(w.weight) * e, e, total2);
    }
    load(factor + cell, scale);
    store(scale * total, sum + cell);
    if constexpr (squares) store(total2, square + cell);
  });
}

}  // namespace

namespace GRUS_LANES {

void lattice_dilation(const LatticeRows& rows, const std::uint8_t* intact, const LatticeColumns& u,
                      const double* factor, double* sum, double* square) {
  square == nullptr ? dilation<false>(rows, intact, u, factor, sum, square)
                    : dilation<true>(rows, intact, u, factor, sum, square);
}

void lattice_forces(const LatticeRows& rows, const std::uint8_t* intact, const LatticeColumns& u, const double* p,
                    const double* q, double* force, std::size_t room) {
  each_group(rows, [&](std::size_t k, std::ptrdiff_t cell, int lane) {
    const Real3 here = at(u, cell);
    Real p_here, q_here;
    load(p + cell, p_here), load(q + cell, q_here);
    Real3 f{0.0, 0.0, 0.0};
    for (std::uint32_t b = rows.octet[k].bond; b < rows.octet[k + 1].bond; ++b) {
      const LatticeWay& w = rows.ways[rows.way[b]];
      Real p_there, q_there;
      load(p + cell + w.step, p_there), load(q + cell + w.step, q_there);
      const Real e = extension(w, here, at(u, cell + w.step));
      const Real pull = fused(Real(w.weight) * e, q_here + q_there, Real(w.moment) * (p_here + p_there));
      const Real t = kept_lanes(mask_of(some(intact[b], lane)), pull);
      f = {fused(t, Real(w.along[0]), f.x), fused(t, Real(w.along[1]), f.y), fused(t, Real(w.along[2]), f.z)};
    }
    double* const to = force + rows.octet[k].point + lane;
    store(f.x, to), store(f.y, to + room), store(f.z, to + 2 * room);
  });
}

void lattice_stiffness(const LatticeRows& rows, const std::uint8_t* intact, const double* q, double* on, double* off,
                       std::size_t room) {
  each_group(rows, [&](std::size_t k, std::ptrdiff_t cell, int lane) {
    Real q_here;
    load(q + cell, q_here);
    Real3 d{0.0, 0.0, 0.0}, o{0.0, 0.0, 0.0};
    for (std::uint32_t b = rows.octet[k].bond; b < rows.octet[k + 1].bond; ++b) {
      const LatticeWay& w = rows.ways[rows.way[b]];
      const double* const n = w.along;
      Real q_there;
      load(q + cell + w.step, q_there);
      const Real t = kept_lanes(mask_of(some(intact[b], lane)), Real(w.weight) * (q_here + q_there));
      d = {fused(t, Real(n[0] * n[0]), d.x), fused(t, Real(n[1] * n[1]), d.y), fused(t, Real(n[2] * n[2]), d.z)};
      o = {fused(t, Real(n[1] * n[2]), o.x), fused(t, Real(n[0] * n[2]), o.y), fused(t, Real(n[0] * n[1]), o.z)};
    }
    const std::size_t to = rows.octet[k].point + static_cast<std::size_t>(lane);
    store(d.x, on + to), store(d.y, on + to + room), store(d.z, on + to + 2 * room);
    store(o.x, off + to), store(o.y, off + to + room), store(o.z, off + to + 2 * room);
  });
}

std::size_t lattice_breaks(const LatticeRows& rows, const std::uint8_t* weak, std::uint8_t* intact,
                           const LatticeColumns& u, double limit, const double* factor, double* sum, double* lost,
                           double* lost_square) {
  std::size_t broken = 0;
  each_group(rows, [&](std::size_t k, std::ptrdiff_t cell, int lane) {
    const Real3 here = at(u, cell);
    Real total(0.0), gone_total(0.0), gone_total2(0.0), scale;
    for (std::uint32_t b = rows.octet[k].bond; b < rows.octet[k + 1].bond; ++b) {
      const LatticeWay& w = rows.ways[rows.way[b]];
      const Real raw = extension(w, here, at(u, cell + w.step));
      const unsigned whole = some(intact[b], lane),
                     gone = bits(less(Real(limit * w.length), raw)) & whole & some(weak[b], lane);
      if (gone != 0) {
        intact[b] = static_cast<std::uint8_t>(intact[b] & ~(gone << lane));
        broken += static_cast<std::size_t>(__builtin_popcount(gone));
        const Real e = kept_lanes(mask_of(gone), raw);
        gone_total = fused(Real(w.moment), e, gone_total), gone_total2 = fused(Real(w.weight) * e, e, gone_total2);
      }
      total = fused(Real(w.moment), kept_lanes(mask_of(whole & ~gone), raw), total);
    }
    load(factor + cell, scale);
    store(scale * total, sum + cell), store(scale * gone_total, lost + cell), store(gone_total2, lost_square + cell);
  });
  return broken;
}

double lattice_stretch(const LatticeRows& rows, const std::uint8_t* intact, const LatticeColumns& u,
                       const std::uint8_t* asked) {
  Real most(0.0);
  each_group(rows, [&](std::size_t k, std::ptrdiff_t cell, int lane) {
    const Real3 here = at(u, cell);
    for (std::uint32_t b = rows.octet[k].bond; b < rows.octet[k + 1].bond; ++b) {
      const LatticeWay& w = rows.ways[rows.way[b]];
      const Real s = extension(w, here, at(u, cell + w.step)) / Real(w.length);
      most = larger(most, kept_lanes(mask_of(some(intact[b] & asked[k], lane)), s));
    }
  });
  double each[width], largest = 0;
  store(most, each);
  for (int l = 0; l < width; ++l) largest = each[l] > largest ? each[l] : largest;
  return largest;
}

}  // namespace GRUS_LANES
}  // namespace grus::dem
