// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/break_plane.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

int first_that_is(bool sought, const bool (&of)[3]) { return static_cast<int>(std::find(of, of + 3, sought) - of); }

}  // namespace

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
    const int good = first_that_is(false, bad);
    const double other = std::max(longest[(good + 1) % 3], longest[(good + 2) % 3]);
    if (width[good] > longer * other) return good;
    return std::nullopt;
  }
  const int one = first_that_is(true, bad);  // case 5 (algorithm 1, with its missing else)
  const int y = (one + 1) % 3, z = (one + 2) % 3;
  if (width[y] > longer * width[z]) return y;
  if (width[z] > longer * width[y]) return z;
  return preference[y] > preference[z] ? y : z;
}

Quat turned_to_plane(const Quat& orientation, int axis, const Vec3& normal) {
  Vec3 local = Vec3::Zero();
  local[axis] = 1;
  const Vec3 from = orientation * local;
  return (Quat::FromTwoVectors(from, from.dot(normal) < 0 ? Vec3(-normal) : normal) * orientation).normalized();
}

Mat3 slight_rotation(double theta, std::uint64_t seed, std::uint64_t id) {
  double angle[3];
  for (std::uint64_t k = 0; k < 3; ++k) {
    const double u = 2 * random_uniform(seed, id, Purpose::rotation, k) - 1;
    angle[k] = std::copysign(0.5 * theta * (1 + std::abs(u)), u);
  }
  // The paper's matrices are passive: R_x(alpha) turns by -alpha about x.
  return (Eigen::AngleAxisd(-angle[0], Vec3::UnitX()) * Eigen::AngleAxisd(-angle[1], Vec3::UnitY()) *
          Eigen::AngleAxisd(-angle[2], Vec3::UnitZ()))
      .toRotationMatrix();
}

}  // namespace grus::dem
