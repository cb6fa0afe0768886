// SPDX-License-Identifier: LGPL-3.0-or-later
// Johnson, Kendall and Roberts for several contacts at a time; the plain form and its formulas are in contact/jkr.hpp.
// Only for the files that are built once for each instruction set.
#pragma once

#include "dem/kernel/contact_chunk.hpp"

namespace grus::dem {
namespace {

struct JkrRow {
  static constexpr bool attracts = true;
  GRUS_INLINE static Pressed press(const ContactRows& s, std::size_t k, Real depth) {
    const Real zero(0.0), one(1.0), two(2.0);
    const Real reach = Real(1.0 / 3) * at(s.reach + k);
    const Real unit = larger(larger(reach, Real(1e-20) * depth), Real(1e-250));
    const Real t = root(larger(depth / unit + Real(3.0), zero));
    Real v = t / (one + root(one + t));
    for (int n = 0; n < 4; ++n) {
      const Real square = fused(v, v + Real(4.0), Real(6.0)), h = root(square);
      v = v - fused_less(v, h, t) * h / fused(v, v + two, square);
    }
    const Real size = one + v, q = size * size * size, base = root(unit) * at(s.stiffness + k), scale = base * unit;
    return {scale * q * (q - Real(6.0)), Real(1.5) * base * size * size, Real(9.0) * scale};
  }
};

}  // namespace
}  // namespace grus::dem
