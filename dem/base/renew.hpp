// SPDX-License-Identifier: LGPL-3.0-or-later
// Columns that are written anew as a whole.
#pragma once

#include <vector>

namespace grus::dem {

/// Room for n values, of which none that is there has to stay. A column that has to grow is given back first, so that
/// it never stands there twice, and grows by a sixteenth more, so that it does not do so each time.
template <class T>
void renew(std::vector<T>& column, std::size_t n) {
  if (n > column.capacity()) std::vector<T>().swap(column), column.reserve(n + n / 16);
  column.resize(n);
}

}  // namespace grus::dem
