// SPDX-License-Identifier: LGPL-3.0-or-later
// Columns that are written anew as a whole.
#pragma once

#include <vector>

namespace grus::dem {

/// A sixteenth more, so that a column does not grow each time.
inline std::size_t with_reserve(std::size_t n) { return n + n / 16; }

/// Room for n values, of which none that is there has to stay. A column that has to grow is given back first, so that
/// it never stands there twice.
template <class T>
void renew(std::vector<T>& column, std::size_t n) {
  if (n > column.capacity()) std::vector<T>().swap(column), column.reserve(with_reserve(n));
  column.resize(n);
}

}  // namespace grus::dem
