// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/hull_overlaps.hpp"

namespace grus::dem {

HullColumns columns_of(const HullView& h) {
  return {h.column, h.column + 3 * h.room, h.edge, h.room, h.space, h.vertices, h.faces, h.edges};
}

HullPose pose_of(const Mat3& turn, const Vec3& shift, const Vec3& search) {
  HullPose pose;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j) pose.turn[3 * i + j] = turn(i, j);
  for (Eigen::Index k = 0; k < 3; ++k) pose.shift[k] = shift[k], pose.search[k] = search[k];
  pose.flush = flush_share, pose.thin = thin;
  return pose;
}

Overlap overlap_of(const HullView& a, const HullView& b, const Mat3& turn, const Vec3& shift, const Vec3& search) {
  static const HullOverlap find = hull_overlap();
  HullWrench w;
  const Meets meets = find(columns_of(a), columns_of(b), pose_of(turn, shift, search), w);
  if (meets == Meets::unsettled) return overlap_by_faces(a, b, turn, shift, search);
  if (meets != Meets::overlaps) return {.parted = meets == Meets::parted};
  return {w.volume, w.energy, Vec3(w.force), Vec3(w.moment), Vec3(w.area), Vec3(w.middle), w.polar, false};
}

}  // namespace grus::dem
