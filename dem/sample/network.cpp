// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/network.hpp"

#include <cstddef>
#include <iterator>

namespace grus::dem {
namespace {

/// Moduli of networks of relaxed periodic cells by the ratio of their shear stiffness, over that of the network.
struct Row {
  double ratio, youngs, poisson;
};
constexpr Row rows[] = {{1, 1, 0},           {0.7, .8703, .0649}, {0.4, .7150, .1425},
                        {0.2, .5881, .2059}, {0.1, .5114, .2443}, {0.05, .4666, .2667}};

/// Between rows k - 1 and k, where the k-th is the first, or the last, that `reached` says is far enough.
template <class Reached>
std::size_t above(Reached reached) {
  std::size_t k = 1;
  while (k + 1 < std::size(rows) && !reached(rows[k])) ++k;
  return k;
}

double between(double low, double high, double share) { return low + share * (high - low); }

}  // namespace

Network network_of(const Elasticity& solid) {
  const std::size_t k = above([&](const Row& r) { return r.poisson >= solid.poissons_ratio; });
  const Row &low = rows[k - 1], &high = rows[k];
  const double share = (solid.poissons_ratio - low.poisson) / (high.poisson - low.poisson);
  return {solid.modulus / between(low.youngs, high.youngs, share), between(low.ratio, high.ratio, share)};
}

Elasticity solid_of(const Network& network) {
  const std::size_t k = above([&](const Row& r) { return r.ratio <= network.ratio; });
  const Row &low = rows[k - 1], &high = rows[k];
  const double share = (network.ratio - low.ratio) / (high.ratio - low.ratio);
  return {network.stiffness * between(low.youngs, high.youngs, share), between(low.poisson, high.poisson, share)};
}

}  // namespace grus::dem
