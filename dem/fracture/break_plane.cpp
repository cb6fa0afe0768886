// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/break_plane.hpp"

#include <algorithm>

namespace grus::dem {

std::optional<int> choose_axis(const PolyEllipsoid& s, const AxisPreference& preference) {
  constexpr double bad_ratio = 0.2, longer = 1.2;
  bool bad[3];
  int bads = 0;
  for (int k = 0; k < 3; ++k) {
    bad[k] = std::min(s.plus[k], s.minus[k]) < bad_ratio * std::max(s.plus[k], s.minus[k]);
    bads += bad[k];
  }
  const Vec3 width = s.plus + s.minus, longest = s.plus.cwiseMax(s.minus);
  if (bads == 0) {  // case 1
    int best;
    preference.maxCoeff(&best);
    return best;
  }
  if (bads == 3) return std::nullopt;  // case 2
  if (bads == 2) {                     // cases 3 and 4: across the good axis, if the body is long enough along it
    const int good = !bad[0] ? 0 : !bad[1] ? 1 : 2;
    const double other = std::max(longest[(good + 1) % 3], longest[(good + 2) % 3]);
    if (width[good] > longer * other) return good;
    return std::nullopt;
  }
  const int one = bad[0] ? 0 : bad[1] ? 1 : 2;  // case 5 (algorithm 1, with its missing else)
  const int y = (one + 1) % 3, z = (one + 2) % 3;
  if (width[y] > longer * width[z]) return y;
  if (width[z] > longer * width[y]) return z;
  return preference[y] > preference[z] ? y : z;
}

}  // namespace grus::dem
