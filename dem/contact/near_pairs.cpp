// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/near_pairs.hpp"

#include "dem/shape/common_normal.hpp"

namespace grus::dem {

bool close(const Grains& g, const Cell& cell, const Candidate& pair, double skin) {
  const Motion &a = g.motion[pair.a], &b = g.motion[pair.b];
  Vec3 r = b.position - a.position;
  if ((pair.image[0] | pair.image[1] | pair.image[2]) != 0)
    r += cell.vectors * Vec3(pair.image[0], pair.image[1], pair.image[2]);
  const double reach = a.radius + b.radius + skin;
  return r.squaredNorm() < reach * reach;
}

bool near(const Grains& g, const Cell& cell, const Candidate& pair, double skin, Vec3& normal) {
  const Frame &fa = g.frame[pair.a], &fb = g.frame[pair.b];
  Vec3 r = fb.origin - fa.origin;
  if (cell.periodic()) r += cell.vectors * Vec3(pair.image[0], pair.image[1], pair.image[2]);
  const ShapePair shapes{g.shape[pair.a], g.shape[pair.b], fa.axes.transpose() * fb.axes, fa.axes.transpose() * r};
  if (normal != Vec3::Zero()) return separation_test(shapes, fa.axes.transpose() * normal) > -skin;
  // Any direction whose separation exceeds the skin settles it: most candidates go here, before the full search.
  const Vec3 line = shapes.r.normalized();
  if (separation_test(shapes, line) < -skin) return false;
  const Vec3 scaled = line.cwiseQuotient(octant_squares(shapes.a, line)).normalized();
  if (separation_test(shapes, scaled) < -skin) return false;
  const CommonNormal found = cold_common_normal(shapes);
  normal = fa.axes * found.normal;
  return !found.converged || found.overlap > -skin;
}

}  // namespace grus::dem
