// SPDX-License-Identifier: LGPL-3.0-or-later
// The faces that face bonds hold: their polygons, what each part of one carries, and bonds on parts of them.
#pragma once

#include "dem/shape/section.hpp"
#include "dem/state/bonds.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// One end of a bond, on a face (global frame) of grain a: where it is, its axes and its moments.
FaceBond bond_at(const Grains& grains, Index a, const FaceMoments& face, const Vec3& normal);

/// The polygon of a bond's face, about `at_a` along e1 and e2: where the faces of both Voronoi cells meet. `walled`: b
/// is a wall, and has none.
FlatPolygon polygon_of(const Grains& grains, const FaceBond& bond, bool walled);

/// The same of two Voronoi cells about its own middle: that of a bond which bears something from birth is a little
/// beside it.
FlatPolygon outline_of(const Grains& grains, const FaceBond& bond);

/// Area (m^2), and second moments against turns about e1 and e2 (m^4).
struct FaceSize {
  double area, i1, i2;
};

/// The share that a part of the face carries of a force (N) and a couple about the middle of the whole (N m), in the
/// axes e1, e2, normal: tractions are linear over the face. The couple is about the middle of the whole, too.
struct FaceWrench {
  Vec3 force, couple;
};
FaceWrench carried(const FaceSize& face, const FaceWrench& whole, const FlatMoments& part);

/// The bond that a part of the face (moments about at_a) has: the same foundation, and what it has gone
/// through. `turn`: of b against a by now. Of a damaged one the parts are opened, and the friction stretched, no
/// further than the whole.
FaceBond part_of(const FaceBond& bond, const FlatMoments& part, const Quat& turn);

/// A grain of a bond gives way to a piece of it: x = turn x' + shift in the grain's own frame, x' in the piece's.
/// `end`: 0 of a, 1 of b.
void rehang(FaceBond& bond, int end, Index piece, const Quat& turn, const Vec3& shift);

}  // namespace grus::dem
