// SPDX-License-Identifier: LGPL-3.0-or-later
// Numbers joined two by two into sets, such as the nodes of a mesh by its elements.
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace grus::fem {

class Joined {
public:
  explicit Joined(std::size_t count) : up_(count) { std::iota(up_.begin(), up_.end(), std::size_t{0}); }
  void join(std::size_t a, std::size_t b) { up_[root(a)] = root(b); }
  /// The number that stands for the set of n.
  std::size_t root(std::size_t n) {
    while (up_[n] != n) n = up_[n] = up_[up_[n]];
    return n;
  }
  /// Those of all sets.
  std::vector<std::size_t> roots() const {
    std::vector<std::size_t> all;
    for (std::size_t n = 0; n < up_.size(); ++n)
      if (up_[n] == n) all.push_back(n);
    return all;
  }

private:
  std::vector<std::size_t> up_;
};

}  // namespace grus::fem
