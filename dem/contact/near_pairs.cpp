// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/near_pairs.hpp"

#include "dem/state/images.hpp"

namespace grus::dem {

bool close(const Grains& g, const Cell& cell, const Candidate& pair, double skin) {
  const Motion &a = g.motion[pair.a], &b = g.motion[pair.b];
  Vec3 r = b.position - a.position;
  if ((pair.image[0] | pair.image[1] | pair.image[2]) != 0) r += at_image(cell.vectors, pair.image);
  const double reach = a.radius + b.radius + skin;
  return r.squaredNorm() < reach * reach;
}

}  // namespace grus::dem
