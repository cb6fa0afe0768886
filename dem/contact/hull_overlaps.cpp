// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/hull_overlaps.hpp"

namespace grus::dem {

HullColumns columns_of(const HullView& h) {
  return {
      h.column, h.column + 3 * h.room, h.edge, h.rows + 4 * h.space, h.rows, h.at, h.room, h.space, h.vertices, h.faces,
      h.edges};
}

HullPose pose_of(const Mat3& a, const Mat3& b, const Vec3& shift, const Vec3& search) {
  return {a.data(), b.data(), shift.data(), search.data(), flush_share, thin, clear_share};
}

Overlap overlap_of(const HullView& a, const HullView& b, const Mat3& axes_a, const Mat3& axes_b, const Vec3& shift,
                   const Vec3& search, HullGuess* guess) {
  static const HullOverlap find = hull_overlap();
  HullWrench w;
  const Meets meets = find(columns_of(a), columns_of(b), pose_of(axes_a, axes_b, shift, search), guess, w);
  if (meets == Meets::unsettled) {
    const Mat3 back = axes_a.transpose();
    return turned(overlap_by_faces(a, b, back * axes_b, back * shift, back * search), axes_a);
  }
  if (meets == Meets::parted) return {.parted = true, .gap = w.gap};
  if (meets != Meets::overlaps) return {};
  return {w.volume, w.energy, Vec3(w.force), Vec3(w.moment), Vec3(w.area), Vec3(w.middle), w.polar};
}

Overlap turned(const Overlap& o, const Mat3& axes) {
  return {o.volume, o.energy, axes * o.force, axes * o.moment, axes * o.area, axes * o.middle,
          o.polar,  o.parted, o.gap};
}

}  // namespace grus::dem
