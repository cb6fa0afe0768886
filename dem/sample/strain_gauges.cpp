// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/strain_gauges.hpp"

#include <limits>
#include <unordered_map>

namespace grus::dem {
namespace {

constexpr double gauged = 0.5;         // of the height, in the middle
constexpr double least_spread = 1e-6;  // of the widest, squared: centres that do not differ

}  // namespace

Mat3 gauged_gradient(const State& first, const State& now, int axis) {
  const double low = first.boundary.walls[0].point[axis], high = first.boundary.walls[1].point[axis];
  const double middle = 0.5 * (low + high), reach = 0.5 * gauged * (high - low);
  std::unordered_map<std::uint64_t, std::size_t> was;
  for (std::size_t i = 0; i < first.grains.size(); ++i)
    if (std::abs(first.grains.motion[i].position[axis] - middle) <= reach) was.emplace(first.grains.id[i], i);
  struct Follower {
    double mass;
    Vec3 at, by;
  };
  std::vector<Follower> pairs;
  double mass = 0;
  Vec3 centre = Vec3::Zero(), shift = Vec3::Zero();
  for (std::size_t i = 0; i < now.grains.size(); ++i) {
    const auto found = was.find(now.grains.id[i]);
    if (found == was.end()) continue;
    const Vec3& x = first.grains.motion[found->second].position;
    const double m = now.grains.mass[i];
    pairs.push_back({m, x, now.grains.motion[i].position - x});
    mass += m, centre += m * x, shift += m * pairs.back().by;
  }
  Mat3 spread = Mat3::Zero(), moved = Mat3::Zero();
  for (const Follower& p : pairs) {
    const Vec3 x = p.at - centre / mass;
    spread += p.mass * x * x.transpose(), moved += p.mass * (p.by - shift / mass) * x.transpose();
  }
  const double widest = pairs.size() < 4 ? 0 : spread.diagonal().maxCoeff();
  Mat3 gradient = Mat3::Constant(std::numeric_limits<double>::quiet_NaN());
  std::vector<int> told;
  for (int k = 0; k < 3; ++k)
    if (spread(k, k) > least_spread * widest && widest > 0) told.push_back(k);
  if (told.size() < 2) return gradient;
  // Only along axes on which the centres lie apart.
  const Eigen::MatrixXd in = spread(told, told), out = moved(told, told);
  const Eigen::MatrixXd best = in.ldlt().solve(out.transpose()).transpose();
  for (std::size_t r = 0; r < told.size(); ++r)
    for (std::size_t c = 0; c < told.size(); ++c)
      gradient(told[r], told[c]) = best(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
  return gradient;
}

}  // namespace grus::dem
